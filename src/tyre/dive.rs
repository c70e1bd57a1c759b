//! What a frame on springs does to its contacts when it dives.

/// Height of the centre of mass above the axles, m: by it times the dive (rad) the centre of mass moves ahead of
/// its place over the wheels.
pub(crate) fn above_axles(cg_height: f64, radius: [f64; 2]) -> f64 {
    (cg_height - 0.5 * (radius[0] + radius[1])).max(0.0)
}

/// Pitch inertia of a motorcycle with rider about its centre of mass over its mass, m², and what it is uncertain
/// by: assumed, no source was looked up; no ride looked at so far tells it.
pub(crate) const PITCH_GYRATION: [f64; 2] = [0.2, 0.05];

/// Share of a turn about the rear contact by which the front goes down in a dive, the rear coming up with
/// the rest.
const FRONT_SHARE: f64 = 0.8;
/// Share of the height above the axles that a swing arm leaves of the rear's arm: a wheel that comes down
/// under it comes forward.
const REAR_SHARE: f64 = 0.7;

/// How fast the contacts fall behind the centre of mass per rate of dive, m, front and rear: both as axles below
/// it, the front also along its rake (a telescopic fork at the caster angle, rad). `wheelbase` in m.
///
/// The independent simulator's are 0.81 and 0.21 m where this gives 0.79 and 0.21 m.
pub(crate) fn contact_arms(
    cg_height: f64,
    radius: [f64; 2],
    wheelbase: f64,
    caster_angle: f64,
) -> [f64; 2] {
    let above = above_axles(cg_height, radius);
    [above + FRONT_SHARE * wheelbase * caster_angle.tan(), REAR_SHARE * above]
}
