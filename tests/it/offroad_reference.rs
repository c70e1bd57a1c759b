//! The off-road equations and riders against `fixtures/reference/offroad_reference.json`: numbers
//! from an independent symbolic derivation, evaluated with 50 digits.

use roadbench::internals::estimate::offroad::nnls;
use roadbench::internals::estimate::offroad::rider::a::{Instant, Standing};
use roadbench::internals::estimate::offroad::rider::{b, c};
use roadbench::internals::estimate::offroad::weights::Weights;
use roadbench::internals::motorcycle::offroad::body::Body;
use roadbench::internals::motorcycle::offroad::chain::{Chain, Run, lever};
use roadbench::internals::motorcycle::offroad::equations::{Equations, Motion, RigidBodies};
use serde_json::Value;

const G: f64 = 9.80665;

fn reference() -> Value {
    let text = include_str!("../../fixtures/reference/offroad_reference.json");
    serde_json::from_str(text).expect("reference")
}

fn list(v: &Value) -> Vec<f64> {
    v.as_array().expect("list").iter().map(|x| x.as_f64().expect("number")).collect()
}

fn array<const N: usize>(v: &Value) -> [f64; N] {
    list(v).try_into().expect("length")
}

fn parameters(v: &Value) -> RigidBodies {
    let get = |k: &str| v[k].as_f64().expect("parameter");
    RigidBodies {
        m: ["m_1", "m_2", "m_3", "m_4"].map(get),
        i: ["I_1", "I_2", "I_3", "I_4"].map(get),
        l_r: get("l_r"),
        l_s: get("l_s"),
        a_r0: get("a_r0"),
        eps: get("eps"),
        b: get("b"),
        h: get("h"),
        w: get("w"),
        r_f: get("R_f"),
        r_r: get("R_r"),
        peg: [get("x_3p"), get("z_3p")],
        bar: [get("x_3h"), get("z_3h")],
    }
}

fn motion(state: &Value) -> Motion {
    let (q, qd) = (array::<5>(&state["q"]), array::<5>(&state["qd"]));
    Motion {
        mu: q[2],
        z_f: q[3],
        a_r: q[4],
        mud: qd[2],
        zd_f: qd[3],
        ad_r: qd[4],
        mu1dd: state["mu1_dd"].as_f64().expect("mu1_dd"),
        mu4dd: state["mu4_dd"].as_f64().expect("mu4_dd"),
    }
}

/// Largest difference over the largest reference value.
fn error(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let scale = expected.iter().fold(1e-3_f64, |m, v| m.max(v.abs()));
    got.iter().zip(expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / scale
}

fn close(got: &[f64], expected: &[f64], what: &str) {
    let error = error(got, expected);
    assert!(error < 1e-10, "{what}: {error:.1e}\n{got:?}\n{expected:?}");
}

fn matrix(v: &Value) -> Vec<f64> {
    v.as_array().expect("rows").iter().flat_map(list).collect()
}

/// Forces from all five columns with the reference's weights.
fn forces(equations: &Equations, state: &Value, at: &[[f64; 5]; 5], b: &[f64; 5]) -> [f64; 5] {
    let weights = Weights::lengths(equations, [false; 5]);
    let diagonal: Vec<f64> = (0..5).map(|k| weights.b_d[k][k]).collect();
    close(&diagonal, &list(&state["B_d"]), "B_d");
    let (hold, b_c) = (array::<5>(&state["W_diag"]), state["B_c"].as_f64().expect("B_c"));
    let (mut g, mut c) = ([[0.0; 5]; 5], [0.0; 5]);
    for row in 0..5 {
        let d = diagonal[row] * diagonal[row];
        for i in 0..5 {
            c[i] += d * at[row][i] * b[row];
            for j in 0..5 {
                g[i][j] += d * at[row][i] * at[row][j];
            }
        }
    }
    for k in 0..5 {
        g[k][k] += (b_c * hold[k]).powi(2);
    }
    nnls::solve(&g, &c, [true; 5])
}

#[test]
fn all_states_agree_with_the_derivation() {
    let reference = reference();
    let states = reference["states"].as_array().expect("states");
    assert_eq!(states.len(), 31);
    let mut worst = 0.0_f64;
    for state in states {
        let name = format!("state {} ({})", state["id"], state["scenario"]);
        let set = state["params"].as_str().expect("params");
        let equations = Equations::new(parameters(&reference["parameters"][set]));
        let m = equations.at(&motion(state));
        close(m.m.as_flattened(), &matrix(&state["M"]), &format!("{name} M"));
        close(&m.mv, &list(&state["m_v"]), &format!("{name} m_v"));
        close(&m.aw, &list(&state["A_w"]), &format!("{name} A_w"));
        close(&m.ar, &list(&state["A_r"][2]), &format!("{name} A_r"));
        close(m.at.as_flattened(), &matrix(&state["A_t"]), &format!("{name} A_t"));
        let base = m.known(&array(&state["qdd"]), array(&state["f_s"]), G);
        let b_1 = m.less_rider(&base, &array(&state["f_r"]));
        close(&b_1, &list(&state["b_1"]), &format!("{name} b_1"));
        let f = forces(&equations, state, &m.at, &b_1);
        close(&f, &list(&state["f_t_nnls"]), &format!("{name} f_t"));
        worst = worst.max(error(&f, &list(&state["f_t_true"])));

        let Some(chain) = state.get("chain") else { continue };
        let sprockets = &reference["chain_geometry"];
        let get = |k: &str| sprockets[k].as_f64().expect("sprocket");
        let (r_p, r_s, centre) = (get("r_p"), get("r_s"), [get("x_c"), get("z_c")]);
        let a_r = motion(state).a_r;
        for (run, key) in [(Run::Upper, "lever_upper"), (Run::Lower, "lever_lower")] {
            let d = lever(&equations, a_r, r_p, r_s, centre, run);
            close(&[d], &[chain[key].as_f64().expect("lever")], &format!("{name} {key}"));
        }
        let kappa = Chain::Geometry { r_p, r_s, centre }.kappa(&equations, a_r);
        close(&[kappa], &[chain["kappa"].as_f64().expect("kappa")], &format!("{name} kappa"));
        let qdd: [f64; 5] = array(&chain["qdd"]);
        let mut b_1 = m.less_rider(&m.known(&qdd, array(&state["f_s"]), G), &array(&state["f_r"]));
        b_1[4] += kappa * equations.p.i[0] * (qdd[2] - qdd[4] + motion(state).mu1dd);
        close(&b_1, &list(&chain["b_1"]), &format!("{name} chain b_1"));
        let mut at = m.at;
        at[4][4] += kappa * equations.p.r_r;
        let f = forces(&equations, state, &at, &b_1);
        close(&f, &list(&chain["f_t_nnls"]), &format!("{name} chain f_t"));
        worst = worst.max(error(&f, &list(&state["f_t_true"])));
    }
    println!("round trip, largest relative error {worst:.1e}");
    assert!(worst < 1e-9);
}

/// The printed appendix has the sign of A_r reversed: a standing rider would lift the bike.
#[test]
fn a_standing_rider_presses_the_bike_down() {
    let reference = reference();
    let state = &reference["states"][0];
    let equations = Equations::new(parameters(&reference["parameters"]["mx450_general"]));
    let m = equations.at(&motion(state));
    let base = m.known(&[0.0; 5], array(&state["f_s"]), G);
    let sum = |fr: [f64; 4]| {
        let f = forces(&equations, state, &m.at, &m.less_rider(&base, &fr));
        f[0] + f[1]
    };
    assert!((sum([0.0, 75.0 * G, 0.0, 0.0]) - 182.0 * G).abs() < 1e-6);
}

fn body(v: &Value) -> Body {
    let get = |k: &str| v[k].as_f64().expect("rider");
    Body {
        mass: get("m_r"),
        k_a: get("k_a"),
        k_l: get("k_l"),
        c_a: get("c_a"),
        c_l: get("c_l"),
        cg: [get("x_A0"), get("z_A0")],
        hip: array(&v["hip"]),
        shoulder: array(&v["shoulder"]),
    }
}

#[test]
fn rider_a_agrees() {
    let reference = reference();
    let r = &reference["rider_A"];
    let p = parameters(&reference["parameters"]["mx450_general"]);
    let standing = Standing::new(&body(&r["params"]), p.peg, p.bar).expect("stands");
    let rest = &r["rest"];
    for (got, key) in [
        (standing.leg.natural, "L_l0"),
        (standing.arm.natural, "L_a0"),
        (standing.leg.length, "L_l"),
        (standing.arm.length, "L_a"),
        (standing.leg.force, "F_l_static"),
    ] {
        close(&[got], &[rest[key].as_f64().expect(key)], key);
    }
    for v in r["vectors"].as_array().expect("vectors") {
        let u = |k: &str| v["u"][k].as_f64().expect(k);
        let x: [f64; 4] = array(&v["x_A"]);
        let y = [x[0] - u("xd_s"), x[1] - u("zd_s"), x[2] - u("x_s"), x[3] - u("z_s")];
        let pitch = u("mu").sin_cos();
        let pull = standing.limb_forces(&y, u("mud"), pitch);
        close(&pull.on_bike, &list(&v["f_r"]), "f_r");
        close(&[pull.leg, pull.arm], &[number(&v["F_l"]), number(&v["F_a"])], "limbs");
        close(&[pull.hip_torque], &[number(&v["T_hip"])], "hip");
        let still = Instant { mu: u("mu"), mud: u("mud"), ..Instant::default() };
        let rate = standing.rate(&y, &still, pitch);
        close(&rate[..2], &list(&v["xdot_A"])[..2], "accelerations");
    }
}

fn number(v: &Value) -> f64 {
    v.as_f64().expect("number")
}

/// Half a second on a moving chassis, relative to it, at 1600 Hz.
#[test]
fn rider_a_integrates_to_the_converged_solution() {
    let reference = reference();
    let r = &reference["rider_A"];
    let p = parameters(&reference["parameters"]["mx450_general"]);
    let standing = Standing::new(&body(&r["params"]), p.peg, p.bar).expect("stands");
    let (w1, w2) = (std::f64::consts::TAU * 2.0, std::f64::consts::TAU * 1.3);
    let base = |t: f64| {
        let mu = 0.08 * (w2 * t).sin();
        let instant = Instant {
            mu,
            mud: 0.08 * w2 * (w2 * t).cos(),
            xdd: -0.02 * w2 * w2 * (w2 * t).sin(),
            zdd: -0.06 * w1 * w1 * (w1 * t).cos(),
        };
        (instant, mu.sin_cos())
    };
    let place = |t: f64| {
        [
            8.0 + 0.02 * w2 * (w2 * t).cos(),
            -0.06 * w1 * (w1 * t).sin(),
            8.0 * t + 0.02 * (w2 * t).sin(),
            -0.06 * (1.0 - (w1 * t).cos()),
        ]
    };
    let simulation = &r["simulation"];
    let (times, states) = (list(&simulation["t"]), simulation["y_converged"].as_array());
    let h = 1.0 / 1600.0;
    let mut y = standing.rest(0.0);
    let mut worst = 0.0_f64;
    for (k, expected) in states.expect("states").iter().enumerate() {
        let t = times[k];
        let (relative, expected) = (place(t), list(expected));
        for i in 0..4 {
            worst = worst.max((y[i] + relative[i] - expected[i]).abs());
        }
        let f = standing.limb_forces(&y, base(t).0.mud, base(t).1).on_bike;
        assert!(error(&f, &list(&simulation["f_r_converged"][k])) < 1e-6);
        for step in 0..80 {
            let at = t + f64::from(step) * h;
            y = standing.step(&y, h, base(at), base(at + 0.5 * h), base(at + h));
        }
    }
    println!("rider A at 1600 Hz, largest error {worst:.1e}");
    assert!(worst < 2e-9, "{worst:.1e}");
}

#[test]
fn rider_a_falls_where_the_derivation_says_so() {
    let reference = reference();
    let p = parameters(&reference["parameters"]["mx450_general"]);
    let mut body = body(&reference["rider_A"]["params"]);
    for case in reference["studies"]["rider_A_fore_aft"].as_array().expect("cases") {
        body.shoulder = [number(&case["shoulder_x"]), -0.4];
        let least = Standing::at_rest(&body, p.peg, p.bar).expect("stands").least_stiffness();
        let expected = number(&case["lowest_stiffness_eig_per_kg"]);
        // the reference differentiates by differences
        assert!((least - expected).abs() < 1e-4 * expected.abs() + 1e-3, "{least} {expected}");
        let refused = Standing::new(&body, p.peg, p.bar);
        assert_eq!(refused.is_err(), expected < 0.0);
        if let Err(message) = refused {
            assert!(message.to_string().contains("offroad.shoulder_x"), "{message}");
        }
    }
}

#[test]
fn riders_b_and_c_agree() {
    let reference = reference();
    for v in reference["rider_B"].as_array().expect("cases") {
        let airborne = v["airborne"].as_bool().expect("flag");
        close(&b::force(75.0, number(&v["xdd_s"]), airborne), &list(&v["f_r"]), "rider B");
    }
    let v = &reference["rider_C"];
    let (cut, rate) = (number(&v["f_c"]), number(&v["f_s"]));
    let (low, high) = c::butterworth(cut, rate);
    close(&low, &list(&v["b"]), "b");
    close(&high, &list(&v["a"]), "a");
    let mut filter = c::Biquad::new((low, high));
    let mut got = Vec::new();
    for k in 0..1600 {
        let bump = if 400 < k && k < 1200 { 9.0 } else { 0.0 };
        let x = 6.0 * (std::f64::consts::TAU * 4.0 * f64::from(k) / rate).sin() + bump;
        let y = filter.next(x);
        if k % 100 == 0 {
            got.push(75.0 * (G - y));
        }
    }
    close(&got, &list(&v["L_z"]), "L_z");
}
