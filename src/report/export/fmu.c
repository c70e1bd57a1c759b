/*
 * FMI 3.0 unit of one tyre, for model exchange and co-simulation. The importer has the FMI headers.
 *
 * One state: the lagged slip angle (eq. 1). A relaxation length of 0 does without: the slip angle acts at once.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "roadbench_tyre.h"

#define TOKEN "@@TOKEN@@"

/* Value references, as modelDescription.xml has them. */
enum {
    TIME, SLIP_RATIO, SLIP_ANGLE, CAMBER, LOAD, FRICTION, WHEEL_SPEED, LAGGED, SETTABLE,
    LAGGED_RATE = SETTABLE, FORCE_X, FORCE_Y, MOMENT_X, MOMENT_Z, ROLLING_FORCE, ROLLING_RADIUS, RIDDEN,
    FIRST_NUMBER = 100,
    NUMBERS = sizeof(roadbench_tyre) / sizeof(double)
};

/* What a state of the unit is. */
typedef struct {
    double values[SETTABLE];
    double numbers[NUMBERS];
} State;

typedef struct {
    State state;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Unit;

#define UNIT(instance) ((Unit *)(instance))
#define VALUES(instance) (UNIT(instance)->state.values)

static fmi3Status refuse(fmi3Instance instance, const char *message)
{
    Unit *unit = UNIT(instance);
    if (unit && unit->log) {
        unit->log(unit->environment, fmi3Error, "error", message);
    }
    return fmi3Error;
}

static void start(Unit *unit)
{
    memset(&unit->state, 0, sizeof unit->state);
    memcpy(unit->state.numbers, &roadbench_@@TYRE@@, sizeof unit->state.numbers);
    unit->state.values[LOAD] = roadbench_@@TYRE@@.nominal_load;
    unit->state.values[FRICTION] = roadbench_@@TYRE@@.reference_friction;
}

static roadbench_tyre tyre_of(const Unit *unit)
{
    roadbench_tyre tyre;
    memcpy(&tyre, unit->state.numbers, sizeof tyre);
    return tyre;
}

/* The slip angle that acts. */
static double acting(const Unit *unit)
{
    const double *v = unit->state.values;
    return tyre_of(unit).relaxation_length > 0.0 ? v[LAGGED] : v[SLIP_ANGLE];
}

static double rate(const Unit *unit)
{
    const double *v = unit->state.values;
    const roadbench_tyre tyre = tyre_of(unit);
    return tyre.relaxation_length > 0.0
               ? roadbench_slip_angle_rate(&tyre, v[WHEEL_SPEED], v[SLIP_ANGLE], v[LAGGED])
               : 0.0;
}

static roadbench_input input_of(const Unit *unit)
{
    const double *v = unit->state.values;
    roadbench_input in;
    in.slip_ratio = v[SLIP_RATIO];
    in.slip_angle = acting(unit);
    in.camber = v[CAMBER];
    in.load = v[LOAD];
    in.friction = v[FRICTION];
    return in;
}

/* Whether there is a number of this reference, and which. */
static int value(const Unit *unit, fmi3ValueReference reference, double *to)
{
    const double *v = unit->state.values;
    const roadbench_tyre tyre = tyre_of(unit);
    const roadbench_input in = input_of(unit);
    const double speed = tyre.rolling_radius * v[WHEEL_SPEED];
    if (reference < SETTABLE) {
        *to = v[reference];
        return 1;
    }
    if (reference >= FIRST_NUMBER && reference < FIRST_NUMBER + NUMBERS) {
        *to = unit->state.numbers[reference - FIRST_NUMBER];
        return 1;
    }
    switch (reference) {
    case LAGGED_RATE: *to = rate(unit); return 1;
    case FORCE_X: *to = roadbench_forces(&tyre, &in).force_x; return 1;
    case FORCE_Y: *to = roadbench_forces(&tyre, &in).force_y; return 1;
    case MOMENT_X: *to = roadbench_forces(&tyre, &in).moment_x; return 1;
    case MOMENT_Z: *to = roadbench_forces(&tyre, &in).moment_z; return 1;
    case ROLLING_FORCE:
        *to = v[LOAD] > 0.0 ? roadbench_rolling_force_at(&tyre, v[LOAD], speed) : 0.0;
        return 1;
    case ROLLING_RADIUS: *to = roadbench_rolling_radius(&tyre, v[LOAD], v[CAMBER], speed); return 1;
    default: return 0;
    }
}

/* Common functions */

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    (void)instance, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

static fmi3Instance instantiate(fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    Unit *unit;
    if (!token || strcmp(token, TOKEN) != 0) {
        if (log) {
            log(environment, fmi3Error, "error", "the instantiation token is that of another unit");
        }
        return NULL;
    }
    unit = malloc(sizeof *unit);
    if (unit) {
        unit->environment = environment;
        unit->log = log;
        start(unit);
    }
    return unit;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiate(token, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n_required, (void)update;
    return instantiate(token, environment, log);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)environment, (void)log, (void)update, (void)lock, (void)unlock;
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start_time, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    VALUES(instance)[TIME] = start_time;
    return fmi3OK;
}

#define NOTHING_TO_DO(name) fmi3Status name(fmi3Instance instance) { (void)instance; return fmi3OK; }
NOTHING_TO_DO(fmi3ExitInitializationMode)
NOTHING_TO_DO(fmi3EnterEventMode)
NOTHING_TO_DO(fmi3Terminate)
NOTHING_TO_DO(fmi3EnterConfigurationMode)
NOTHING_TO_DO(fmi3ExitConfigurationMode)
NOTHING_TO_DO(fmi3EnterContinuousTimeMode)
NOTHING_TO_DO(fmi3EnterStepMode)
NOTHING_TO_DO(fmi3EvaluateDiscreteStates)

fmi3Status fmi3Reset(fmi3Instance instance)
{
    start(UNIT(instance));
    return fmi3OK;
}

/* Values */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3Float64 values[],
                          size_t n_values)
{
    size_t i;
    if (n != n_values) {
        return refuse(instance, "fmi3GetFloat64: as many values as references, all are scalars");
    }
    for (i = 0; i < n; i++) {
        if (!value(UNIT(instance), references[i], &values[i])) {
            return refuse(instance, "fmi3GetFloat64: there is no such variable");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                          const fmi3Float64 values[], size_t n_values)
{
    size_t i;
    if (n != n_values) {
        return refuse(instance, "fmi3SetFloat64: as many values as references, all are scalars");
    }
    for (i = 0; i < n; i++) {
        const fmi3ValueReference reference = references[i];
        if (reference > TIME && reference < SETTABLE) {
            VALUES(instance)[reference] = values[i];
        } else if (reference >= FIRST_NUMBER && reference < FIRST_NUMBER + NUMBERS) {
            UNIT(instance)->state.numbers[reference - FIRST_NUMBER] = values[i];
        } else {
            return refuse(instance, "fmi3SetFloat64: this variable cannot be set");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3Boolean values[],
                          size_t n_values)
{
    const roadbench_tyre tyre = tyre_of(UNIT(instance));
    const roadbench_input in = input_of(UNIT(instance));
    size_t i;
    for (i = 0; i < n; i++) {
        if (references[i] != RIDDEN || n != n_values) {
            return refuse(instance, "fmi3GetBoolean: there is no such variable");
        }
        values[i] = roadbench_ridden(&tyre, &in) ? fmi3True : fmi3False;
    }
    return fmi3OK;
}

/* Variables of other types: there are none. */
#define NO_GET(name, type)                                                                                    \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference references[], size_t n, type values[], size_t m) \
    {                                                                                                         \
        (void)references, (void)values;                                                                       \
        return n == 0 && m == 0 ? fmi3OK : refuse(instance, #name ": there is no variable of this type");     \
    }
#define NO_SET(name, type) NO_GET(name, const type)
NO_GET(fmi3GetFloat32, fmi3Float32)
NO_GET(fmi3GetInt8, fmi3Int8)
NO_GET(fmi3GetUInt8, fmi3UInt8)
NO_GET(fmi3GetInt16, fmi3Int16)
NO_GET(fmi3GetUInt16, fmi3UInt16)
NO_GET(fmi3GetInt32, fmi3Int32)
NO_GET(fmi3GetUInt32, fmi3UInt32)
NO_GET(fmi3GetInt64, fmi3Int64)
NO_GET(fmi3GetUInt64, fmi3UInt64)
NO_GET(fmi3GetString, fmi3String)
NO_SET(fmi3SetFloat32, fmi3Float32)
NO_SET(fmi3SetInt8, fmi3Int8)
NO_SET(fmi3SetUInt8, fmi3UInt8)
NO_SET(fmi3SetInt16, fmi3Int16)
NO_SET(fmi3SetUInt16, fmi3UInt16)
NO_SET(fmi3SetInt32, fmi3Int32)
NO_SET(fmi3SetUInt32, fmi3UInt32)
NO_SET(fmi3SetInt64, fmi3Int64)
NO_SET(fmi3SetUInt64, fmi3UInt64)
NO_SET(fmi3SetBoolean, fmi3Boolean)
NO_SET(fmi3SetString, fmi3String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, size_t sizes[],
                         fmi3Binary values[], size_t m)
{
    (void)references, (void)sizes, (void)values, (void)m;
    return n == 0 ? fmi3OK : refuse(instance, "fmi3GetBinary: there is no variable of this type");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t m)
{
    (void)references, (void)sizes, (void)values, (void)m;
    return n == 0 ? fmi3OK : refuse(instance, "fmi3SetBinary: there is no variable of this type");
}

/* The whole state */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    if (!*state) {
        *state = malloc(sizeof(State));
    }
    if (!*state) {
        return refuse(instance, "fmi3GetFMUState: no memory");
    }
    memcpy(*state, &UNIT(instance)->state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    memcpy(&UNIT(instance)->state, state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    (void)instance;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    (void)instance, (void)state;
    *size = sizeof(State);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size < sizeof(State)) {
        return refuse(instance, "fmi3SerializeFMUState: the buffer is too small");
    }
    memcpy(bytes, state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (size != sizeof(State)) {
        return refuse(instance, "fmi3DeserializeFMUState: the bytes are not of this unit");
    }
    if (!*state) {
        *state = malloc(sizeof(State));
    }
    if (!*state) {
        return refuse(instance, "fmi3DeserializeFMUState: no memory");
    }
    memcpy(*state, bytes, sizeof(State));
    return fmi3OK;
}

/* Model exchange */

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    VALUES(instance)[TIME] = time;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    (void)instance;
    *n = 1;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    (void)instance;
    *n = 0;
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t n)
{
    if (n != 1) {
        return refuse(instance, "fmi3GetContinuousStates: there is one state");
    }
    states[0] = VALUES(instance)[LAGGED];
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t n)
{
    if (n != 1) {
        return refuse(instance, "fmi3SetContinuousStates: there is one state");
    }
    VALUES(instance)[LAGGED] = states[0];
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n)
{
    if (n != 1) {
        return refuse(instance, "fmi3GetContinuousStateDerivatives: there is one state");
    }
    derivatives[0] = rate(UNIT(instance));
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n)
{
    if (n != 1) {
        return refuse(instance, "fmi3GetNominalsOfContinuousStates: there is one state");
    }
    nominals[0] = 0.1;
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n)
{
    (void)indicators;
    return n == 0 ? fmi3OK : refuse(instance, "fmi3GetEventIndicators: there are none");
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_state, fmi3Boolean *enter_event_mode,
                                       fmi3Boolean *terminate)
{
    (void)instance, (void)no_set_state;
    *enter_event_mode = fmi3False;
    *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next)
{
    (void)instance, (void)next;
    *again = *terminate = *nominals_changed = *states_changed = *next_defined = fmi3False;
    return fmi3OK;
}

/* Co-simulation: inputs hold for the step, over which the lag is integrated exactly. */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 now, fmi3Float64 step, fmi3Boolean no_set_state,
                      fmi3Boolean *event_handling, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    double *v = VALUES(instance);
    const roadbench_tyre tyre = tyre_of(UNIT(instance));
    (void)no_set_state;
    if (tyre.relaxation_length > 0.0) {
        const double path = fabs(tyre.rolling_radius * v[WHEEL_SPEED]) * step;
        v[LAGGED] = v[SLIP_ANGLE] + (v[LAGGED] - v[SLIP_ANGLE]) * exp(-path / tyre.relaxation_length);
    }
    v[TIME] = now + step;
    *event_handling = *terminate = *early = fmi3False;
    *last = v[TIME];
    return fmi3OK;
}

/* What the unit does not have */

#define UNSUPPORTED(name, parameters, unused)                          \
    fmi3Status name parameters                                         \
    {                                                                  \
        unused;                                                        \
        return refuse(instance, #name ": this unit does not have it"); \
    }
UNSUPPORTED(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Clock a[]),
            ((void)r, (void)n, (void)a))
UNSUPPORTED(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const fmi3Clock a[]),
            ((void)r, (void)n, (void)a))
UNSUPPORTED(fmi3GetNumberOfVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t *n),
            ((void)r, (void)n))
UNSUPPORTED(fmi3GetVariableDependencies, (fmi3Instance instance, fmi3ValueReference r, size_t a[],
            fmi3ValueReference b[], size_t c[], fmi3DependencyKind d[], size_t n),
            ((void)r, (void)a, (void)b, (void)c, (void)d, (void)n))
UNSUPPORTED(fmi3GetDirectionalDerivative, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3ValueReference a[], size_t b, const fmi3Float64 c[], size_t d, fmi3Float64 e[], size_t f),
            ((void)r, (void)n, (void)a, (void)b, (void)c, (void)d, (void)e, (void)f))
UNSUPPORTED(fmi3GetAdjointDerivative, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3ValueReference a[], size_t b, const fmi3Float64 c[], size_t d, fmi3Float64 e[], size_t f),
            ((void)r, (void)n, (void)a, (void)b, (void)c, (void)d, (void)e, (void)f))
UNSUPPORTED(fmi3GetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64
            a[], fmi3IntervalQualifier b[]),
            ((void)r, (void)n, (void)a, (void)b))
UNSUPPORTED(fmi3GetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64
            a[], fmi3UInt64 b[], fmi3IntervalQualifier c[]),
            ((void)r, (void)n, (void)a, (void)b, (void)c))
UNSUPPORTED(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3Float64
            a[]),
            ((void)r, (void)n, (void)a))
UNSUPPORTED(fmi3GetShiftFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, fmi3UInt64
            a[], fmi3UInt64 b[]),
            ((void)r, (void)n, (void)a, (void)b))
UNSUPPORTED(fmi3SetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3Float64 a[]),
            ((void)r, (void)n, (void)a))
UNSUPPORTED(fmi3SetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3UInt64 a[], const fmi3UInt64 b[]),
            ((void)r, (void)n, (void)a, (void)b))
UNSUPPORTED(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3Float64 a[]),
            ((void)r, (void)n, (void)a))
UNSUPPORTED(fmi3SetShiftFraction, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3UInt64 a[], const fmi3UInt64 b[]),
            ((void)r, (void)n, (void)a, (void)b))
UNSUPPORTED(fmi3GetOutputDerivatives, (fmi3Instance instance, const fmi3ValueReference r[], size_t n, const
            fmi3Int32 a[], fmi3Float64 b[], size_t c),
            ((void)r, (void)n, (void)a, (void)b, (void)c))
UNSUPPORTED(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 a),
            ((void)r, (void)a))
