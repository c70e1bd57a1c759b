/*
@@WHO@@
 *
 * The motorcycle tyre model of Bartolozzi, Massaro, Mottola and Savino (2024), equations 1-22, with
 * the departures that roadbench documents. C99, no dependency but libm. SI units, angles in radians.
 *
 * Axes of ISO 8855: x forward, y left, z up. A positive slip ratio drives; a positive slip angle or
 * camber pulls to the right (negative Fy); in a left-hand corner camber is negative and Fy positive.
 * Forces act where the wheel plane meets the road. Rolling resistance comes on top of Fx.
 *
 *     roadbench_input in = {.slip_ratio = -0.05, .slip_angle = 0.0, .camber = -0.3,
 *                           .load = 1300.0, .friction = roadbench_@@FIRST@@.reference_friction};
 *     roadbench_output out = roadbench_forces(&roadbench_@@FIRST@@, &in);
 */
#ifndef ROADBENCH_TYRE_H
#define ROADBENCH_TYRE_H

#include <math.h>

/* One tyre. */
typedef struct {
@@FIELDS@@
} roadbench_tyre;

typedef struct {
    double slip_ratio; /* positive driving */
    double slip_angle; /* rad, lagged by roadbench_slip_angle_rate */
    double camber;     /* rad */
    double load;       /* N */
    double friction;   /* of the road; reference_friction is that of the ride */
} roadbench_input;

typedef struct {
    double force_x, force_y;   /* N */
    double moment_x, moment_z; /* N m */
} roadbench_output;

/* Engaged longitudinal friction over slip ratio, eq. 28. */
static inline double roadbench_friction_x(const roadbench_tyre *t, double s)
{
    const double x = t->mf_b * s;
    const double e = t->mf_e1 + t->mf_e2 * copysign(1.0, s);
    return t->mf_d * sin(t->mf_c * atan(x - e * (x - atan(x))));
}

/* Radius of the friction circle over load on a road, under the nominal load. */
static inline double roadbench_circle(const roadbench_tyre *t, double friction)
{
    const double along = fabs(t->mf_d), mu = friction > 1e-3 ? friction : 1e-3;
    return (along > t->lateral_peak ? along : t->lateral_peak) * mu / t->reference_friction;
}

/* Share of a force that a friction circle leaves, both in N. */
static inline double roadbench_share(double force_x, double force_y, double circle)
{
    const double square = force_x * force_x + force_y * force_y;
    return square > circle * circle ? circle / sqrt(square) : 1.0;
}

/* Cornering stiffness per load, 1/rad, eq. 39; its denominator stays above a fifth of the upright. */
static inline double roadbench_cornering_stiffness(const roadbench_tyre *t, double camber)
{
    const double upright = t->c1 + t->side_force_ratio;
    const double tangent = fabs(camber) < 1e-6 ? 1.0 : tan(camber) / camber;
    double per_camber = upright + t->c3 * camber * camber;
    if (upright > 0.0 && per_camber < 0.2 * upright) {
        per_camber = 0.2 * upright;
    }
    return -t->ct * tangent / per_camber;
}

/* Pneumatic trail at vanishing slip, m, eq. 12. */
static inline double roadbench_trail(const roadbench_tyre *t, double load)
{
    const double deflection = load > 0.0 ? load / t->vertical_stiffness : 0.0;
    const double unloaded = t->rolling_radius + deflection / 3.0;
    const double loaded = unloaded - deflection;
    const double square = unloaded * unloaded - loaded * loaded;
    return square > 0.0 ? sqrt(square) / 3.0 : 0.0;
}

/* Rolling resistance, N, eq. 21. */
static inline double roadbench_rolling_force(const roadbench_tyre *t, double load)
{
    return -t->rolling_resistance * load;
}

/* Rolling resistance at a speed, N: eq. 21, and what it gains with speed. */
static inline double roadbench_rolling_force_at(const roadbench_tyre *t, double load, double speed)
{
    return -(t->rolling_resistance + t->rolling_speed * fabs(speed)) * load;
}

/* Effective rolling radius, m. */
static inline double roadbench_rolling_radius(const roadbench_tyre *t, double load, double camber,
                                              double speed)
{
    const double deflection = t->nominal_load / t->vertical_stiffness;
    const double unloaded = t->rolling_radius + t->deflection_share * deflection;
    const double crown = t->overturning_stiffness + deflection;
    const double versine = 1.0 - cos(camber), grown = speed / 20.0;
    const double radius =
        unloaded - crown * versine - t->deflection_share * load / t->vertical_stiffness;
    const double share = 1.0 + t->radius_speed * grown * grown
                         - t->radius_load * (load - t->nominal_load) / 1000.0;
    return radius * share - t->radius_camber * t->width_over_front * versine;
}

/* Rate of the lagged slip angle, rad/s, eq. 1; omega is the wheel's speed, rad/s. */
static inline double roadbench_slip_angle_rate(const roadbench_tyre *t, double omega,
                                               double kinematic, double lagged)
{
    return t->rolling_radius * fabs(omega) / t->relaxation_length * (kinematic - lagged);
}

/* Forces and moments, eqs. 2-20, and what was named beyond them; nothing in the air. */
static inline roadbench_output roadbench_forces(const roadbench_tyre *t, const roadbench_input *in)
{
    roadbench_output out = {0.0, 0.0, 0.0, 0.0};
    const double load = in->load, camber = in->camber;
    const double mu = in->friction > 1e-3 ? in->friction : 1e-3;
    const double most = t->peak_slip, ratio = t->side_force_ratio, k_x = t->overturning_stiffness;
    if (!(load > 0.0)) {
        return out;
    }
    const double extra = load / t->nominal_load - 1.0;
    const double gained = 1.0 + t->slip_stiffness_load * extra;
    const double slip = in->slip_ratio * (gained > 0.2 ? gained : 0.2);
    const double rolling = 1.0 + slip > 1e-4 ? 1.0 + slip : 1e-4;
    const double s = rolling - 1.0;
    const double sigma_x = -s / rolling;                   /* (2a) */
    const double sigma_y = -tan(in->slip_angle) / rolling; /* (2b) */
    const double x = sigma_x / most, y = sigma_y / most;   /* (3) */
    const double n = sqrt(x * x + y * y);                  /* (4) */

    const double direction = sigma_x > 0.0 ? 1.0 : (sigma_x < 0.0 ? -1.0 : 0.0);
    const double signed_x = n * most * direction;
    const double one = 1.0 + signed_x > 1e-4 ? 1.0 + signed_x : 1e-4;
    const double s_eq = -signed_x / one;                        /* (5a) */
    const double tan_alpha = sigma_y == 0.0 ? 0.0 : n * most;   /* (5b), size */

    const double similar = t->reference_friction / mu;
    const double fx0 = fabs(roadbench_friction_x(t, similar * s_eq)) * load; /* (6a) */
    const double k = roadbench_cornering_stiffness(t, camber);
    const double fy0 = k * load * fabs(similar * atan(tan_alpha)); /* (6b) */

    const double cos_l = n > 0.0 ? fabs(x) / n : 1.0; /* (9) */
    const double sin_l = n > 0.0 ? y / n : 0.0;
    const double gamma = n < 1.0 ? n : 1.0;
    const double fx_basic = fx0 - gamma * (fx0 - fy0) * sin_l * sin_l; /* (7a) */
    const double fy_basic = fy0 - gamma * (fy0 - fx0) * cos_l * cos_l; /* (7b) */
    const double fx_free = -cos_l / similar * fx_basic * direction;    /* (8a) */
    const double fy_alpha_free = sin_l / similar * fy_basic;           /* (8b) */
    const double fy_gamma_free =
        -ratio * k * load * camber / (1.0 + t->camber_force_decay * x * x); /* (13)-(15) */

    /* both forces end at the friction circle, in the direction that they have */
    const double circle = roadbench_circle(t, mu) * load;
    const double share = roadbench_share(fx_free, fy_alpha_free + fy_gamma_free, circle);
    const double fx = share * fx_free, fy_alpha = share * fy_alpha_free;
    const double fy_gamma = share * fy_gamma_free;

    const double k0 = roadbench_cornering_stiffness(t, 0.0);
    const double left = 1.0 - k0 / (3.0 * mu) * tan_alpha;
    const double trail = roadbench_trail(t, load) * (left > 0.0 ? left : 0.0); /* (11) */
    const double mz_gamma = -t->twisting_stiffness * load * camber
                            / (1.0 + t->camber_moment_decay * n * n); /* (16), (17) */
    const double by_slip = -k * in->slip_angle * load;
    const double less = 1.0 - k / 3.0 * fabs(tan(in->slip_angle));
    const double more =
        t->pneumatic_trail * roadbench_trail(t, t->nominal_load) * (less > 0.0 ? less : 0.0);
    const double friction_over = 1.0 - t->friction_load * extra;
    const double stiffness_over = 1.0 + t->stiffness_load * extra;
    const double less_friction = friction_over > 0.2 ? friction_over : 0.2;
    const double more_side = stiffness_over > 0.2 ? stiffness_over : 0.2;
    const double force_x = fx * less_friction, force_y = (fy_alpha + fy_gamma) * more_side;
    const double within = roadbench_share(force_x, force_y, less_friction * circle);
    out.force_x = force_x * within;
    out.force_y = force_y * within;
    out.moment_x = -k_x * load * tan(camber);                                /* (18) */
    out.moment_z = -trail * fy_alpha + mz_gamma + k_x * fx * tan(camber) /* (10), (19), (20) */
                   - more * by_slip;
    return out;
}

/*
 * 1 where all of it was ridden: on the road of the ride (another friction was not ridden), within its ranges, and not
 * both slips at once: of slip ratio and side force one is less than a twentieth of its peak.
 */
static inline int roadbench_ridden(const roadbench_tyre *t, const roadbench_input *in)
{
    const double side = fabs(roadbench_cornering_stiffness(t, in->camber)
                             * (in->slip_angle + t->side_force_ratio * in->camber));
    const int along = fabs(in->slip_ratio) > 0.05 * t->peak_slip;
    const int across = side > 0.05 * t->side_friction_max;
    return fabs(in->friction / t->reference_friction - 1.0) <= 1e-6 && !(along && across)
           && in->slip_ratio >= t->slip_ratio_min && in->slip_ratio <= t->slip_ratio_max
           && fabs(in->slip_angle) <= t->slip_angle_max && fabs(in->camber) <= t->camber_max
           && in->load >= t->load_min && in->load <= t->load_max
           && side <= t->side_friction_max * (1.0 + 1e-9);
}
@@TYRES@@
#endif
