//! Which tyre has the force, by the wheels' slip.

pub(crate) use crate::motorcycle::balance::USUAL_SLIP_STIFFNESS as SLIP_STIFFNESS;

/// Front share `x` of a braking force (as part of the weight): `slip = force (x / (K n_f) - (1 - x) / (K_r n_r))` with
/// [`SLIP_STIFFNESS`] in front, `stiffness` behind and the front load `on_front` as part of the weight.
pub(super) fn front_share(slip: f64, force: f64, on_front: f64, stiffness: f64) -> f64 {
    let front = on_front.clamp(0.05, 0.95);
    let rear = (1.0 - front) * (stiffness / SLIP_STIFFNESS);
    (slip * SLIP_STIFFNESS + force / rear) / (force / front + force / rear)
}
