/* This file handles "orders" (shared/wire/wire_orders.def). Orders are all commands that the core receives
 * for a tick, except the positions of the hands. Every command to the core is checked in this file and
 * nowhere else. In LOCKSTEP, the commands to the core are part of a tick's input. In FREE_RUN, the commands
 * to the core arrive in the message `orders` and wait for a tick. */
#include "firmware/app/app_internal.h"

/* --- one order --- */

/* Each handler fills in its own kind of command, and returns false when a value is out of its range. */

static bool take_rhythm(const crn_app *app, const crn_wire_order *order, crn_app_order_set *taken)
{
    (void)app;
    taken->rhythm = (crn_rhythm_order){order->rhythm.action, order->rhythm.value};
    return taken->rhythm.action != CRN_RHYTHM_KEEP && crn_rhythm_order_is_valid(&taken->rhythm);
}

static bool take_scaffold(const crn_app *app, const crn_wire_order *order, crn_app_order_set *taken)
{
    const crn_wire_scaffold *wire = &order->scaffold;
    taken->scaffold = (crn_scaffold){wire->lesion - 1u, wire->first, wire->last, wire->open_q15 << 15};
    return wire->first <= wire->last &&
           wire->last < crn_model_stations(&app->model, taken->scaffold.lesion) && wire->open_q15 >= 1 &&
           wire->open_q15 <= 1 << 15;
}

static bool take_strut(const crn_app *app, const crn_wire_order *order, crn_app_order_set *taken)
{
    (void)app;
    const crn_wire_strut *wire = &order->strut;
    taken->strut = (crn_strut_order){wire->number,
                                     {wire->x_um, wire->y_um, wire->z_um},
                                     wire->inside_um,
                                     wire->thickness_um,
                                     wire->joined};
    return wire->number != 0 && crn_strut_order_is_valid(&taken->strut);
}

/* Checks only the numbers in an order to exchange tools; whether the exchange is possible depends on the
 * state at its tick. */
static bool take_exchange(const crn_app *app, const crn_wire_order *order, crn_app_order_set *taken)
{
    taken->has_exchange = true;
    taken->exchange = (crn_exchange_order){order->exchange.position, order->exchange.tool};
    return order->exchange.position < app->setup.tool_count && order->exchange.tool <= app->setup.table_count;
}

/* The program does not compile when a kind of command has no handler. */
static bool (*const handlers[])(const crn_app *, const crn_wire_order *, crn_app_order_set *) = {
#define ORDER(name, kind, text) [CRN_WIRE_KIND_##name] = take_##name,
#include "shared/wire/wire_orders.def"
};

/* --- the orders of one tick --- */

uint16_t crn_app_orders_take(const crn_app *app, const crn_wire_order_list *list, crn_app_order_set *taken,
                             uint32_t *place)
{
    uint32_t kinds = 0;
    *taken = (crn_app_order_set){.has_exchange = false};
    for (*place = 0; *place < list->items_count; ++*place) {
        const crn_wire_order *order = &list->items[*place]; /* its kind is known: the codec refuses others */
        if ((kinds >> order->kind & 1u) != 0) return CRN_REJECT_ORDER_TWICE;
        kinds |= 1u << order->kind;
        if (!handlers[order->kind](app, order, taken)) return CRN_REJECT_ORDER_RANGE;
    }
    return CRN_REJECT_NONE;
}

/* --- an exchange, between two ticks --- */

/* The core and the wire protocol list the same answers to an exchange of tools. The program does not compile
 * when the core's list differs from that of the wire protocol. */
#define EXCHANGE(NAME, number, text, remedy)                                                                 \
    _Static_assert((int)CRN_EXCHANGE_##NAME + 1 == (int)(number), "core and wire agree about " #NAME);
#include "shared/wire/wire_exchanges.def"

void crn_app_exchange(crn_app *app, const crn_app_order_set *orders)
{
    app->session.exchange = CRN_WIRE_EXCHANGE_NONE;
    if (!orders->has_exchange) return;
    const crn_exchange_status status = crn_exchange(&app->model, &app->core, &orders->exchange);
    app->session.exchange = (uint8_t)(status + 1);
    if (status == CRN_EXCHANGE_DONE) crn_haptics_let_go(&app->haptics, orders->exchange.position);
}

/* --- FREE_RUN --- */

/* The app may repeat or drop a message `input`, but never a command to the core: each list of commands waits
 * for its own tick. */
void crn_app_orders(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_orders;
    crn_wire_orders message;
    CRN_REJECT_IF(app, type, !crn_wire_decode_orders(payload, length, &message), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_orders);
    CRN_REJECT_IF(app, type, app->mode != CRN_WIRE_MODE_FREE_RUN, CRN_REJECT_WRONG_MODE, app->mode, 0);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type, message.orders.items_count == 0, CRN_REJECT_ORDER_MISPLACED, 0, 0);
    crn_app_tick_orders orders = {.wire = message.orders};
    uint32_t place;
    const uint16_t code = crn_app_orders_take(app, &message.orders, &orders.core, &place);
    CRN_REJECT_IF(app, type, code != CRN_REJECT_NONE, code, message.orders.items[place].kind, place);
    CRN_REJECT_IF(app, type, app->session.order_count == CRN_APP_ORDER_QUEUE, CRN_REJECT_ORDER_FULL,
                  message.orders.items[0].kind, app->session.order_count);
    app->session.orders[(app->session.order_first + app->session.order_count++) % CRN_APP_ORDER_QUEUE] =
        orders;
    crn_app_send_status(app, type);
}

const crn_app_tick_orders *crn_app_orders_next(crn_app *app)
{
    static const crn_app_tick_orders none;
    if (app->session.order_count == 0) return &none;
    const crn_app_tick_orders *orders = &app->session.orders[app->session.order_first];
    app->session.order_first = (app->session.order_first + 1) % CRN_APP_ORDER_QUEUE;
    app->session.order_count--;
    return orders;
}
