#!/usr/bin/env python3
"""These tests check the following. The Wireshark dissector decodes the frames of the wire protocol correctly. The test
makes frames independently of the project's code (COBS, CRC-32 and layout as in docs/wire.md), and writes them to a
capture file. The program tshark must then print the frames' values, join split frames and report damaged frames. Prints
TAP."""

import os
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
DOCS = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin", "docs")
USER0, USB_LINUX = 147, 220


def stuffed(body):
    """Encodes bytes by the definition of COBS: the encoded bytes contain no zero, and a length precedes every block of
    at most 254 bytes."""
    out, block = bytearray(), bytearray()
    for byte in body + b"\0":
        if byte == 0:
            out += bytes([len(block) + 1]) + block
            block = bytearray()
            continue
        block.append(byte)
        if len(block) == 254:
            out += b"\xff" + block
            block = bytearray()
    return bytes(out) + b"\0"


def frame(sequence, kind, payload, flip=0):
    body = struct.pack("<HHHH", sequence, 0, kind, len(payload)) + payload
    return stuffed(body + struct.pack("<I", zlib.crc32(body) ^ flip))


def on_bus(data, device):
    """Returns the bytes of the record that usbmon of Linux writes for a bulk transfer to endpoint 2 (struct mon_bin_hdr
    of 64 bytes in Documentation/usb/usbmon.rst)."""
    header = struct.pack(
        "<QBBBBHBBqiiII8siiII",
        1,
        ord("S"),
        3,
        2,
        device,
        1,
        ord("-"),
        0,
        0,
        0,
        -115,
        len(data),
        len(data),
        bytes(8),
        0,
        0,
        0,
        0,
    )
    return header + data


def capture(packets, kind):
    data = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, kind)
    for i, packet in enumerate(packets):
        data += struct.pack("<IIII", i, 0, len(packet), len(packet)) + packet
    return data


def dissect(script, path, *fields):
    """Runs tshark on the capture file and returns, for each packet and field, a list of texts."""
    command = [
        "tshark",
        "-X",
        "lua_script:" + script,
        "-r",
        path,
        "-T",
        "fields",
        "-E",
        "separator=;",
        "-E",
        "occurrence=a",
    ]
    for field in ("_ws.col.Info",) + fields:
        command += ["-e", field]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if done.returncode != 0 or "Lua" in done.stderr:
        return None, done.stderr
    return [line.split(";") for line in done.stdout.splitlines()], done.stderr


def packets_of_test():
    hello = frame(1, 0x01, struct.pack("<HHQ", 3, 0, 0x0123456789ABCDEF))
    hand = struct.pack("<ii", -5, 70000)
    orders = struct.pack("<BBBH", 2, 1, 6, 1) + struct.pack("<BBBiiiHH", 3, 64, 1, 5, -6, 7, 1500, 81)
    tick = struct.pack("<H", 1) + hand + struct.pack("<Iii", 1, -2, 3) + orders
    step = frame(2, 0x20, struct.pack("<IBH", 41, 1, 2) + tick + tick)
    unknown = frame(8, 0x27, struct.pack("<BBBH", 1, 9, 6, 1))
    reject = frame(3, 0x03, struct.pack("<HHII", 0x20, 4, 2, 0))
    notice = frame(4, 0x25, struct.pack("<IIHHii", 9, 1000, 2, 13, 0, 0))
    chunk = frame(5, 0x11, struct.pack("<IH", 4096, 600) + bytes(range(1, 251)) * 2 + bytes(100))
    damaged = frame(6, 0x01, struct.pack("<HHQ", 3, 0, 1), flip=1)
    short = frame(7, 0x20, struct.pack("<IB", 41, 1))
    return [hello, step, reject + notice, chunk[:300], chunk[300:], damaged, short, unknown]


CLAIMS = [
    ("the_schema_hash_of_a_hello_is_read", 0, "cournand.hello.schema_hash", "81985529216486895"),
    ("a_hand_s_counts_are_signed", 1, "cournand.hand.translation_counts", "-5,-5"),
    ("the_syringe_s_counts_are_read", 1, "cournand.tick_input.syringe_counts", "-2,-2"),
    ("the_kinds_of_orders_are_read", 1, "cournand.order.kind", "1,3,1,3"),
    ("an_order_s_fields_are_read", 1, "cournand.strut.y_um", "-6,-6"),
    ("an_order_of_an_unknown_kind_is_marked", 7, "_ws.expert.message", "payload does not have the message's form"),
    ("a_step_s_tick_is_read", 1, "cournand.step.tick", "41"),
    ("two_frames_in_one_packet_are_both_read", 2, "_ws.col.Info", "reject, notice"),
    ("a_refusal_has_its_text", 2, "cournand.reject", "WRONG_STATE: not possible in this state (detail: state)"),
    (
        "a_fault_has_its_text",
        2,
        "cournand.fault",
        "EMERGENCY_STOP: the emergency stop was pressed, or its loop is open",
    ),
    ("half_a_frame_waits", 3, "_ws.col.Info", "part of a frame"),
    ("the_other_half_completes_it", 4, "cournand.scene_chunk.offset", "4096"),
    ("a_damaged_frame_is_marked", 5, "_ws.col.Info", "damaged hello"),
    ("a_payload_without_its_form_is_marked", 6, "_ws.expert.message", "payload does not have the message's form"),
]


# This capture began after the device was plugged in, so it does not contain the device's class. Another device of the
# class "vendor" must not be taken for ours.
def packets_of_bus():
    ours = packets_of_test()
    return [
        on_bus(packet, device)
        for packet, device in [(ours[3], 2), (b"other" + bytes(27), 3), (ours[0], 2), (ours[3], 2), (ours[4], 2)]
    ]


BUS_CLAIMS = [
    ("before_the_first_whole_frame_a_pipe_is_nobody_s", 0, "_ws.col.Info", "URB_BULK out"),
    ("another_device_s_bytes_are_left_alone", 1, "_ws.col.Info", "URB_BULK out"),
    ("a_frame_on_the_bus_is_found_without_the_device_s_class", 2, "_ws.col.Info", "hello"),
    ("from_then_on_the_pipe_is_read", 4, "cournand.scene_chunk.offset", "4096"),
]


def main():
    fields = sorted({claim[2] for claim in CLAIMS} - {"_ws.col.Info"})
    with tempfile.TemporaryDirectory() as folder:
        script, path = os.path.join(folder, "cournand.lua"), os.path.join(folder, "wire.pcap")
        made = subprocess.run([DOCS, "--dissector", script], cwd=ROOT, capture_output=True, text=True, timeout=60)
        rows, errors = [], made.stderr
        for packets, kind in ((packets_of_test(), USER0), (packets_of_bus(), USB_LINUX)):
            with open(path, "wb") as file:
                file.write(capture(packets, kind))
            more, errors = dissect(script, path, *fields) if made.returncode == 0 else (None, errors)
            rows = rows + more if rows is not None and more is not None else None
    if rows is None:
        print("not ok 1 - the_dissector_is_loaded_by_tshark")
        print("# " + errors.replace("\n", "\n# "))
        print("1..1")
        sys.exit(1)
    print("ok 1 - the_dissector_is_loaded_by_tshark")
    status = 0
    claims = CLAIMS + [
        (name, len(packets_of_test()) + packet, field, expected) for name, packet, field, expected in BUS_CLAIMS
    ]
    for number, (name, packet, field, expected) in enumerate(claims, 2):
        got = rows[packet][0 if field == "_ws.col.Info" else 1 + fields.index(field)]
        status |= got != expected
        print("%sok %d - %s" % ("" if got == expected else "not ", number, name))
        if got != expected:
            print("# packet %d, %s: '%s', expected '%s'" % (packet, field, got, expected))
    print("1..%d" % (1 + len(claims)))
    sys.exit(status)


if __name__ == "__main__":
    main()
