-- The part of the Wireshark dissector that is the same for every version of the wire: frames, CRC and trees. `make
-- dissector` puts the tables `records`, `choices` and `messages` of shared/wire/wire_messages.def, `faults` and
-- `rejects` above it.
--
--   wireshark -X lua_script:out/cournand.lua capture.pcapng
--
-- It is asked for bulk transfers of the vendor interface (class 0xff), and for captures of the kind USER0, whose
-- packets hold the pipe's bytes. A frame may span packets; each direction of each device is put together by itself.

local bits = bit32 or bit
local proto = Proto("cournand", "Cournand")
local fields = {}

-- --- fields: one per value of the definition -------------------------------------------------------------------------
local sizes = { u8 = 1, u16 = 2, u32 = 4, u64 = 8, i16 = 2, i32 = 4 }
local makers = { u8 = ProtoField.uint8, u16 = ProtoField.uint16, u32 = ProtoField.uint32, u64 = ProtoField.uint64,
    i16 = ProtoField.int16, i32 = ProtoField.int32 }

local function add_fields(owner, list)
    for _, field in ipairs(list) do
        local abbreviation = "cournand." .. owner .. "." .. field.name
        local title = field.name .. (field.unit ~= "" and field.unit ~= "1" and " [" .. field.unit .. "]" or "")
        if field.max then
            local make = field.count_bytes == 1 and ProtoField.uint8 or ProtoField.uint16
            fields[abbreviation .. "_count"] = make(abbreviation .. "_count", field.name .. " count")
        end
        if makers[field.type] then fields[abbreviation] = makers[field.type](abbreviation, title) end
    end
end

local type_names = {}
for name, record in pairs(records) do add_fields(name, record.fields) end
for number, message in pairs(messages) do
    type_names[number] = message.name
    add_fields(message.name, message.fields)
end

for name, options in pairs(choices) do
    fields["cournand." .. name .. ".kind"] = ProtoField.uint8("cournand." .. name .. ".kind", "kind", base.DEC, options)
end

fields.sequence = ProtoField.uint16("cournand.sequence", "sequence")
fields.answers = ProtoField.uint16("cournand.answers", "answers the request")
fields.type = ProtoField.uint16("cournand.type", "type", base.HEX, type_names)
fields.length = ProtoField.uint16("cournand.length", "payload length")
fields.crc32 = ProtoField.uint32("cournand.crc32", "CRC-32", base.HEX)
fields.fault = ProtoField.string("cournand.fault", "fault")
fields.reject = ProtoField.string("cournand.reject", "refusal")
local listed = {}
for _, field in pairs(fields) do listed[#listed + 1] = field end
proto.fields = listed
local malformed = ProtoExpert.new("cournand.malformed", "damaged frame", expert.group.MALFORMED, expert.severity.ERROR)
proto.experts = { malformed }

-- --- frames: COBS and CRC-32 (docs/wire.md, "Frames") ----------------------------------------------------------------
local function unstuff(bytes)
    local out, i = {}, 1
    while i <= #bytes do
        local code = bytes:byte(i)
        if i + code > #bytes + 1 then return nil end
        out[#out + 1] = bytes:sub(i + 1, i + code - 1)
        i = i + code
        if code < 255 and i <= #bytes then out[#out + 1] = "\0" end
    end
    return table.concat(out)
end

local crc_table = {}
for i = 0, 255 do
    local c = i
    for _ = 1, 8 do
        c = bits.band(c, 1) == 1 and bits.bxor(bits.rshift(c, 1), 0xedb88320) or bits.rshift(c, 1)
    end
    crc_table[i] = c
end

local function crc32(bytes)
    local c = 0xffffffff
    for i = 1, #bytes do
        c = bits.bxor(bits.rshift(c, 8), crc_table[bits.band(bits.bxor(c, bytes:byte(i)), 0xff)])
    end
    return bits.bxor(c, 0xffffffff) % 4294967296
end

-- --- values ----------------------------------------------------------------------------------------------------------
-- Adds the fields of one record or message; the place behind them, or nil when bytes are missing.
local add_values

local function add_value(tree, owner, field, tvb, place)
    if sizes[field.type] then
        if place + sizes[field.type] > tvb:len() then return nil end
        tree:add_le(fields["cournand." .. owner .. "." .. field.name], tvb(place, sizes[field.type]))
        return place + sizes[field.type]
    end
    local branch, record = tree:add(tvb(place), field.name), field.type
    if choices[record] then
        if place >= tvb:len() then return nil end
        branch:add(fields["cournand." .. record .. ".kind"], tvb(place, 1))
        record = choices[record][tvb(place, 1):uint()]
        if not record then return nil end
        place = place + 1
    end
    return add_values(branch, record, records[record].fields, tvb, place)
end

function add_values(tree, owner, list, tvb, place)
    for _, field in ipairs(list) do
        local count = 1
        if field.max then
            if place + field.count_bytes > tvb:len() then return nil end
            count = tvb(place, field.count_bytes):le_uint()
            tree:add_le(fields["cournand." .. owner .. "." .. field.name .. "_count"], tvb(place, field.count_bytes))
            place = place + field.count_bytes
            if count > field.max then return nil end
        end
        if field.max and field.type == "u8" then -- bytes: the first and their number say enough
            if place + count > tvb:len() then return nil end
            if count > 0 then tree:add(tvb(place, count), field.name .. ": " .. count .. " bytes") end
            place = place + count
        else
            for _ = 1, count do
                place = add_value(tree, owner, field, tvb, place)
                if not place then return nil end
            end
        end
    end
    return place
end

local function add_meaning(tree, message, payload)
    if message.name == "reject" and payload:len() >= 4 then
        local code = payload(2, 2):le_uint()
        tree:add(fields.reject, payload(2, 2), rejects[code] or "unknown refusal " .. code)
    elseif message.name == "notice" and payload:len() >= 12 and payload(8, 2):le_uint() == 2 then
        local code = payload(10, 2):le_uint()
        tree:add(fields.fault, payload(10, 2), faults[code] or "unknown fault " .. code)
    end
end

-- --- one frame -------------------------------------------------------------------------------------------------------
local function add_frame(stuffed, tree, names)
    local body = unstuff(stuffed)
    if not body or #body < 12 then
        tree:add(proto, "Cournand: damaged frame"):add_proto_expert_info(malformed, "COBS or size")
        return "damaged"
    end
    local tvb = ByteArray.new(body, true):tvb("Cournand frame")
    local number, length = tvb(4, 2):le_uint(), tvb(6, 2):le_uint()
    local message = messages[number]
    local name = message and message.name or string.format("unknown 0x%02x", number)
    local branch = tree:add(proto, tvb(), "Cournand: " .. name)
    branch:add_le(fields.sequence, tvb(0, 2))
    branch:add_le(fields.answers, tvb(2, 2))
    branch:add_le(fields.type, tvb(4, 2))
    branch:add_le(fields.length, tvb(6, 2))
    branch:add_le(fields.crc32, tvb(#body - 4, 4))
    if crc32(body:sub(1, #body - 4)) ~= tvb(#body - 4, 4):le_uint() then
        branch:add_proto_expert_info(malformed, "CRC-32 differs")
        return "damaged " .. name
    end
    if length ~= #body - 12 then
        branch:add_proto_expert_info(malformed, "length differs")
        return "damaged " .. name
    end
    if not message then return name end
    if length > 0 then
        local payload = tvb(8, length):tvb()
        local behind = add_values(branch, message.name, message.fields, payload, 0)
        if behind ~= length then branch:add_proto_expert_info(malformed, "payload does not have the message's form") end
        add_meaning(branch, message, payload)
    end
    return name
end

-- --- packets ---------------------------------------------------------------------------------------------------------
local rests = {}   -- by direction: bytes of a frame that is not complete
local befores = {} -- by packet: what was there before it, so that a second pass sees the same
local claimed = {} -- by direction: the first packet that held a whole frame

function proto.init()
    rests, befores, claimed = {}, {}, {}
end

local function direction_of(pinfo)
    return tostring(pinfo.src) .. ">" .. tostring(pinfo.dst)
end

function proto.dissector(tvb, pinfo, tree)
    local direction = direction_of(pinfo)
    if not pinfo.visited then befores[pinfo.number] = rests[direction] or "" end
    local bytes = (befores[pinfo.number] or "") .. tvb:raw()
    local names = {}
    local from = 1
    while true do
        local zero = bytes:find("\0", from, true)
        if not zero then break end
        if zero > from then names[#names + 1] = add_frame(bytes:sub(from, zero - 1), tree) end
        from = zero + 1
    end
    if not pinfo.visited then rests[direction] = bytes:sub(from) end
    pinfo.cols.protocol = "Cournand"
    pinfo.cols.info = #names > 0 and table.concat(names, ", ") or "part of a frame"
    return tvb:len()
end

-- A pipe is ours from its first frame whose CRC-32 is right: a capture that began after the device was plugged in
-- knows neither its numbers nor the class of its interfaces, and other devices use the class "vendor" too.
local function holds_a_frame(bytes)
    for stuffed in bytes:gmatch("[^%z]+%z") do
        local body = unstuff(stuffed:sub(1, -2))
        if body and #body >= 12 then
            local low, high = body:byte(-4) + body:byte(-3) * 256, body:byte(-2) + body:byte(-1) * 256
            if crc32(body:sub(1, -5)) == low + high * 65536 then return true end
        end
    end
    return false
end

local function is_ours(tvb, pinfo, tree)
    local direction = direction_of(pinfo)
    if not claimed[direction] and holds_a_frame(tvb:raw()) then claimed[direction] = pinfo.number end
    if not claimed[direction] or pinfo.number < claimed[direction] then return false end
    proto.dissector(tvb, pinfo, tree)
    return true
end

proto:register_heuristic("usb.bulk", is_ours)
DissectorTable.get("wtap_encap"):add(wtap.USER0, proto)
