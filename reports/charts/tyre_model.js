// The tyre of src/tyre/paper.rs with src/tyre/custom.rs, equation by equation: [Fx, Fy, Mx, Mz] of slip ratio, slip
// angle, camber (rad), load (N) and road friction over that of the ride. Each page carries points of the program's own
// model, and explorer.js holds this one against them.
const tyreModel = p => {
  const curve = s => {
    const bs = p.mf_b * s, e = p.mf_e1 + p.mf_e2 * (s < 0 ? -1 : 1);
    return p.mf_d * Math.sin(p.mf_c * Math.atan(bs - e * (bs - Math.atan(bs)))); // (28)
  };
  const kAlpha = gamma => {
    const upright = p.slip_camber_c1 + p.side_force_ratio;
    let per = upright + p.slip_camber_c3 * gamma * gamma;
    if (upright > 0) per = Math.max(per, 0.2 * upright);
    return -p.lateral_friction_ct * (Math.abs(gamma) < 1e-6 ? 1 : Math.tan(gamma) / gamma) / per; // (39)
  };
  // a slip counts as so many times itself under another load
  const stiffer = load => Math.max(0.2, 1 + p.slip_stiffness_load * (load / p.load_at_rest - 1));
  const circle = mu => Math.max(Math.abs(p.mf_d), p.lateral_peak) * mu;
  const trail = load => {
    const deflection = Math.max(0, load / p.vertical_stiffness), free = p.effective_rolling_radius + deflection / 3;
    return Math.sqrt(Math.max(0, free ** 2 - (free - deflection) ** 2)) / 3; // (12)
  };
  const forces = (slip, angle, gamma, load, mu) => {
    const least = 1e-4, tanGamma = Math.tan(gamma), C = p.side_force_ratio, top = p.peak_slip;
    const rolling = Math.max(least, 1 + stiffer(load) * slip), s = rolling - 1;
    const sx = -s / rolling / top, sy = -Math.tan(angle) / rolling / top, n = Math.hypot(sx, sy); // (2), (3), (4)
    const along = n * top * Math.sign(sx), eq = -along / Math.max(least, 1 + along); // (5a)
    const across = sy === 0 ? 0 : n * top, k = kAlpha(gamma); // (5b)
    const fx0 = Math.abs(curve(eq / mu)) * load, fy0 = k * load * Math.abs(Math.atan(across) / mu); // (6)
    const [cos, sin] = n > 0 ? [Math.abs(sx) / n, sy / n] : [1, 0], mix = Math.min(1, n);
    let fx = -cos * mu * (fx0 - mix * (fx0 - fy0) * sin * sin) * Math.sign(sx); // (7a), (8a)
    let fa = sin * mu * (fy0 - mix * (fy0 - fx0) * cos * cos); // (7b), (8b)
    let fg = -C * k * load * gamma / (1 + p.camber_force_decay * sx * sx); // (15)
    const size = Math.hypot(fx, fa + fg), most = circle(mu) * load;
    if (size > most) [fx, fa, fg] = [fx, fa, fg].map(f => f * most / size);
    const left = Math.max(0, 1 - kAlpha(0) / (3 * mu) * across); // (11)
    const twist = -p.twisting_stiffness * load * gamma / (1 + p.camber_moment_decay * n * n); // (16), (17)
    const offset = p.overturning_stiffness * tanGamma;
    return [fx, fa + fg, -offset * load, -trail(load) * left * fa + twist + offset * fx]; // (18), (20)
  };
  return { forces, kAlpha, stiffer, circle };
};
