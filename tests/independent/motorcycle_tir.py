"""Reads an exported property file as its user would, and compares it with the fitted tyre.

    python3 motorcycle_tir.py TYRE.tir COEFFICIENTS.toml TABLES.csv front|rear

Nothing here comes from roadbench: the reader of the file and the Magic Formulas are written from
Pacejka (2012), Tire and Vehicle Dynamics, 3rd ed. - the motorcycle set 5.2 (FITTYP 52) from
section 11.6 and de Vries and Pacejka (1998), version 6.2 (FITTYP 62) from section 4.3.2, equations
4.E1 to 4.E78 without turn slip and pressure; the fitted tyre from the paper's eqs. 22, 28 and 39
with the coefficients of the TOML export, and, for moments and combined slip, from the look-up
tables. Prints one JSON object: largest differences over what was ridden and over the ranges that
the file states, over the largest value there, and whether the file behaves over all of its ranges.

No package on PyPI was found that reads such a file: `pacejka` 0.1.0 evaluates four constants.
"""

import csv
import json
import sys
import tomllib
from math import atan, cos, copysign, exp, pi, sin, tan


def read(path):
    """Section -> key -> number or text; comments from $ or !."""
    sections, current = {}, {}
    for line in open(path, encoding="utf-8"):
        line = line.split("$")[0].split("!")[0].strip()
        if line.startswith("["):
            current = sections.setdefault(line.strip("[]"), {})
        elif "=" in line:
            key, value = (part.strip() for part in line.split("=", 1))
            try:
                current[key] = float(value)
            except ValueError:
                current[key] = value.strip("'\"")
    return sections


class Motorcycle:
    """MF-MCTyre: ISO axes, coefficients by their names in the file."""

    def __init__(self, sections):
        assert sections["MODEL"]["FITTYP"] == 52, "not the motorcycle set"
        units = sections["UNITS"]
        assert (units["LENGTH"], units["FORCE"], units["ANGLE"]) == ("meter", "newton", "radians")
        self.p = {k: v for s in sections.values() for k, v in s.items()}

    def forces(self, kappa, alpha, gamma, load):
        p = self.p
        fz0, r0 = p["FNOMIN"], p["UNLOADED_RADIUS"]
        dfz = (load - fz0) / fz0

        def bend(c, e, x):
            return c * atan(x - e * (x - atan(x)))

        def sign(x):
            return 0.0 if x == 0 else copysign(1.0, x)

        # longitudinal, pure
        cx = p["PCX1"]
        dx = load * (p["PDX1"] + p["PDX2"] * dfz)
        kx = load * (p["PKX1"] + p["PKX2"] * dfz) * exp(p["PKX3"] * dfz)
        slip = kappa + p["PHX1"] + p["PHX2"] * dfz
        ex = (p["PEX1"] + p["PEX2"] * dfz + p["PEX3"] * dfz**2) * (1 - p["PEX4"] * sign(slip))
        fx0 = dx * sin(bend(cx, ex, kx / (cx * dx) * slip)) + load * (p["PVX1"] + p["PVX2"] * dfz)
        bxa = p["RBX1"] * cos(atan(p["RBX2"] * kappa))
        fx = fx0 * cos(p["RCX1"] * atan(bxa * alpha))

        # lateral: slip angle and camber each through a formula of its own
        def lateral(alpha, gamma):
            g2 = gamma * gamma
            stiffness = (p["PKY1"] * fz0
                         * sin(p["PKY2"] * atan(load / ((p["PKY3"] + p["PKY4"] * g2) * fz0)))
                         / (1 + p["PKY5"] * g2))
            camber_stiffness = load * (p["PKY6"] + p["PKY7"] * dfz)
            dy = load * p["PDY1"] * exp(p["PDY2"] * dfz) / (1 + p["PDY3"] * g2)
            a = alpha + p["PHY1"]
            ey = p["PEY1"] + p["PEY2"] * g2 + (p["PEY3"] + p["PEY4"] * gamma) * sign(a)
            of_slip = bend(p["PCY1"], min(ey, 1.0), stiffness / (p["PCY1"] * dy) * a)
            of_camber = bend(p["PCY2"], p["PEY5"], camber_stiffness / (p["PCY2"] * dy) * gamma)
            return dy * sin(of_slip + of_camber), stiffness

        fy0, _ = lateral(alpha, gamma)
        byk = p["RBY1"] * cos(atan(p["RBY2"] * (alpha - p["RBY3"])))
        weight = cos(p["RCY1"] * atan(byk * kappa))
        fy = weight * fy0

        # moments
        mx = r0 * load * (p["QSX1"] - p["QSX2"] * gamma + p["QSX3"] * fy / fz0)
        upright, stiffness = lateral(alpha, 0.0)
        equivalent = sign(alpha) * (alpha**2 + (kx / stiffness * kappa) ** 2) ** 0.5
        trail = (load * r0 / fz0 * (p["QDZ1"] + p["QDZ2"] * dfz)
                 * cos(bend(p["QCZ1"], p["QEZ1"], p["QBZ1"] * equivalent)) * cos(atan(alpha)))
        residual = load * r0 * p["QDZ8"] * gamma * cos(atan(p["QBZ9"] * alpha)) * cos(atan(alpha))
        arm = r0 * (p["SSZ1"] + p["SSZ2"] * fy / fz0 + (p["SSZ3"] + p["SSZ4"] * dfz) * gamma)
        mz = -trail * weight * upright + residual + arm * fx
        return fx, fy, mx, mz


class MagicFormula62:
    """Version 6.2 in the W axes; a coefficient that the file has not is zero."""

    def __init__(self, sections):
        assert sections["MODEL"]["FITTYP"] == 62, "not version 6.2"
        units = sections["UNITS"]
        assert (units["LENGTH"], units["FORCE"], units["ANGLE"]) == ("meter", "newton", "radians")
        self.p = {k: v for s in sections.values() for k, v in s.items()}
        scales = [k for k, v in self.p.items() if k.startswith("L") and v != 1.0]
        known = ["LENGTH", "LONGVL", "LONGITUDINAL_STIFFNESS", "LATERAL_STIFFNESS"]
        assert set(scales) <= set(known), "no scaling factors are written"

    def forces(self, kappa, alpha, gamma, load):
        def p(name):
            return self.p.get(name, 0.0)

        def sgn(x):
            return 0.0 if x == 0 else copysign(1.0, x)

        def curved(b, e, x):  # the argument that E bends
            return b * x - e * (b * x - atan(b * x))

        fz0, r0 = p("FNOMIN"), p("UNLOADED_RADIUS")
        dfz = (load - fz0) / fz0  # 4.E2a
        astar, gstar = tan(alpha), sin(gamma)  # 4.E3, 4.E4

        # longitudinal, pure: 4.E9 to 4.E18
        kx = kappa + p("PHX1") + p("PHX2") * dfz
        mux = (p("PDX1") + p("PDX2") * dfz) * (1 - p("PDX3") * gamma**2)
        ex = (p("PEX1") + p("PEX2") * dfz + p("PEX3") * dfz**2) * (1 - p("PEX4") * sgn(kx))
        kxk = load * (p("PKX1") + p("PKX2") * dfz) * exp(p("PKX3") * dfz)
        bx = kxk / (p("PCX1") * mux * load)
        fx0 = mux * load * sin(p("PCX1") * atan(curved(bx, ex, kx)))
        fx0 += load * (p("PVX1") + p("PVX2") * dfz)

        # lateral, pure: 4.E19 to 4.E30
        def lateral(gstar):
            kya = p("PKY1") * fz0 * (1 - p("PKY3") * abs(gstar))
            kya *= sin(p("PKY4") * atan(load / fz0 / (p("PKY2") + p("PKY5") * gstar**2)))
            kyg = load * (p("PKY6") + p("PKY7") * dfz)
            svyg = load * (p("PVY3") + p("PVY4") * dfz) * gstar
            svy = load * (p("PVY1") + p("PVY2") * dfz) + svyg
            shy = p("PHY1") + p("PHY2") * dfz + (kyg * gstar - svyg) / kya
            ay = astar + shy
            muy = (p("PDY1") + p("PDY2") * dfz) * (1 - p("PDY3") * gstar**2)
            ey = (p("PEY1") + p("PEY2") * dfz) * (
                1 + p("PEY5") * gstar**2 - (p("PEY3") + p("PEY4") * gstar) * sgn(ay)
            )
            by = kya / (p("PCY1") * muy * load)
            fy0 = muy * load * sin(p("PCY1") * atan(curved(by, min(ey, 1.0), ay))) + svy
            return fy0, kya, by * p("PCY1"), shy + svy / kya, muy

        fy0, kya, bcy, shf, muy = lateral(gstar)

        # combined: 4.E50 to 4.E67
        def falls(c, b, e, shift, x):
            at = [cos(c * atan(curved(b, e, y))) for y in (x + shift, shift)]
            return at[0] / at[1]

        bxa = (p("RBX1") + p("RBX3") * gstar**2) * cos(atan(p("RBX2") * kappa))
        exa = p("REX1") + p("REX2") * dfz
        fx = fx0 * falls(p("RCX1"), bxa, exa, p("RHX1"), astar)

        def gyk(gstar):
            byk = (p("RBY1") + p("RBY4") * gstar**2) * cos(atan(p("RBY2") * (astar - p("RBY3"))))
            shift = p("RHY1") + p("RHY2") * dfz
            return falls(p("RCY1"), byk, p("REY1") + p("REY2") * dfz, shift, kappa)

        dvyk = muy * load * (p("RVY1") + p("RVY2") * dfz + p("RVY3") * gstar)
        dvyk *= cos(atan(p("RVY4") * astar))
        fy = gyk(gstar) * fy0 + dvyk * sin(p("RVY5") * atan(p("RVY6") * kappa))

        # overturning moment: 4.E69
        side = fy / fz0
        mx = p("QSX1") - p("QSX2") * gamma - p("QSX12") * gamma * abs(gamma) + p("QSX3") * side
        mx += p("QSX10") * atan(p("QSX11") * load / fz0) * gamma
        mx = r0 * load * mx + r0 * fy * (p("QSX13") + p("QSX14") * abs(gamma))

        # aligning moment: 4.E31 to 4.E49 and 4.E71 to 4.E78
        upright, *_ = lateral(0.0)
        at = astar + p("QHZ1") + p("QHZ2") * dfz + (p("QHZ3") + p("QHZ4") * dfz) * gstar
        ar = astar + shf
        equivalent = [sgn(x) * (x**2 + (kxk / kya * kappa) ** 2) ** 0.5 for x in (at, ar)]
        bt = (p("QBZ1") + p("QBZ2") * dfz + p("QBZ3") * dfz**2) * (
            1 + p("QBZ5") * abs(gstar) + p("QBZ6") * gstar**2
        )
        dt = load * r0 / fz0 * (p("QDZ1") + p("QDZ2") * dfz)
        dt *= 1 + p("QDZ3") * abs(gstar) + p("QDZ4") * gstar**2
        et = p("QEZ1") + p("QEZ2") * dfz + p("QEZ3") * dfz**2
        et *= 1 + (p("QEZ4") + p("QEZ5") * gstar) * 2 / pi * atan(bt * p("QCZ1") * at)
        trail = dt * cos(p("QCZ1") * atan(curved(bt, et, equivalent[0]))) * cos(alpha)
        br = p("QBZ9") + p("QBZ10") * bcy
        dr = p("QDZ6") + p("QDZ7") * dfz + (p("QDZ8") + p("QDZ9") * dfz) * gstar
        dr += (p("QDZ10") + p("QDZ11") * dfz) * gstar * abs(gstar)
        residual = load * r0 * dr * cos(alpha) * cos(atan(br * equivalent[1]))
        arm = r0 * (p("SSZ1") + p("SSZ2") * side + (p("SSZ3") + p("SSZ4") * dfz) * gstar)
        return fx, fy, mx, -trail * gyk(0.0) * upright + residual + arm * fx


SETS = {52: Motorcycle, 62: MagicFormula62}


def fitted(tyre, ranges, at_rest, effects):
    """Fx/Fz over slip ratio and Fy/Fz over slip angle and camber, as fitted (eqs. 28, 39, 22).

    Both take the load over that at rest, less 1: `effects` are those that a diagnosis named and the
    export added to the tyre.
    """
    value = {name: row.get("value") for name, row in tyre.items()}
    b, c, d, e1 = (value[k] for k in ("mf_b", "mf_c", "mf_d", "mf_e1"))
    e2 = value["mf_e2"] or 0.0
    more = sum(size for name, size in effects.items() if name.startswith("side_force_ratio"))
    ratio = value["side_force_ratio"] + more
    d = at_rest or d

    def friction_x(s, extra):
        falls = 1 - effects.get("friction_load", 0.0) * extra
        e = e1 + e2 * copysign(1.0, s)
        return falls * d * sin(c * atan(b * s - e * (b * s - atan(b * s))))

    # tan(gamma)/gamma / k_alpha is linear in gamma²: from the first and last point of the curve
    curve = ranges["stiffness_over_camber"]
    compliance = [((tan(g) / g if g else 1.0) / k, g * g) for g, k in curve]
    t1 = compliance[0][0]
    t2 = (compliance[-1][0] - t1) / compliance[-1][1]
    # of another side-force ratio the slips that were measured over camber stay
    upright = t1 + more / abs(value["lateral_friction_ct"])
    middle, g2 = compliance[len(curve) // 2]
    # the tables' curves are in single precision
    assert abs(middle / (t1 + t2 * g2) - 1) < 1e-6, "the curve is not of the family"

    def friction_y(alpha, gamma, extra):
        k = (tan(gamma) / gamma if gamma else 1.0) / (upright + t2 * gamma * gamma)
        return -k * (alpha + ratio * gamma) * (1 + effects.get("stiffness_load", 0.0) * extra)

    return friction_x, friction_y, abs(value["lateral_friction_ct"])


def steps(low, high, n):
    return [low + (high - low) * i / (n - 1) for i in range(n)]


class Worst:
    def __init__(self):
        self.off = self.largest = 0.0
        self.points = 0

    def see(self, found, wanted):
        self.off = max(self.off, abs(found - wanted))
        self.largest = max(self.largest, abs(wanted))
        self.points += 1

    def share(self):
        return self.off / self.largest if self.largest else None


def behaves(tyre):
    """What a simulator needs of all the ranges of the file, whatever tyre it is of."""
    p = tyre.p
    peak, camber, angle = p["PDY1"], p["CAMMAX"], p["ALPMAX"]
    most, reached = 0.0, 0.0
    for load in (p["FZMIN"], p["FNOMIN"], p["FZMAX"]):
        dfz = load / p["FNOMIN"] - 1
        at_load = exp(p["PDY2"] * dfz) * peak if p["FITTYP"] == 52 else peak + p["PDY2"] * dfz
        for gamma in steps(-camber, camber, 21):
            pulls = []
            for alpha in steps(-angle, angle, 41):
                _, fy, _, _ = tyre.forces(0.0, alpha, gamma, load)
                most = max(most, abs(fy) / load / at_load)
                pulls.append(-fy / load / at_load)
            # a larger slip angle never pulls much less, and both ends pull to their own side
            for k in range(1, 41):
                assert pulls[k] > pulls[k - 1] - 0.05, (load, gamma, k, pulls)
            assert pulls[0] < -0.2 and pulls[-1] > 0.2, (load, gamma, pulls)
        upright = [abs(tyre.forces(0.0, a, 0.0, load)[1]) for a in steps(0.0, angle, 351)]
        reached = max(reached, abs(max(upright) / load / at_load - 1))
        for kappa in steps(p["KPUMIN"], p["KPUMAX"], 41):
            for alpha in steps(-angle, angle, 15):
                for gamma in steps(-camber, camber, 7):
                    fx, fy, mx, mz = tyre.forces(kappa, alpha, gamma, load)
                    assert fx * kappa >= 0, ("Fx pushes against the slip", kappa, alpha, gamma)
                    free = tyre.forces(0.0, alpha, gamma, load)[1]
                    assert fy * free >= 0, ("braking turns the side force", kappa, alpha, gamma)
                    assert abs(fy) <= abs(free) * (1 + 1e-9), (kappa, alpha, gamma)
                    assert abs(mx) < 0.3 * load and abs(mz) < 0.2 * load, (mx, mz)
    return {"most": most, "peak off": reached}


def main(tir, coefficients, tables, end):
    sections = read(tir)
    tyre = SETS[int(sections["MODEL"]["FITTYP"])](sections)
    with open(coefficients, "rb") as file:
        document = tomllib.load(file)
    effects = {
        one["effect"]: one["value"]
        for one in document.get("effects", [])
        if one["place"].get(end) == "added"
    }
    at_rest = document.get("mf_d_at_rest", {}).get(end)
    ridden = document["ranges"][end]
    friction_x, friction_y, ct = fitted(document[end], ridden, at_rest, effects)
    gain = document[end]["slip_stiffness_load"]["value"]
    p = tyre.p

    def size(name):
        return max(abs(x) for x in ridden[name])

    # the ranges of the file hold what was ridden, and more
    angle, camber = size("slip_angle"), size("camber")
    assert p["ALPMAX"] >= 0.3 > angle and p["CAMMAX"] >= camber and -p["ALPMIN"] == p["ALPMAX"]
    assert p["KPUMIN"] <= ridden["slip_ratio"][0] and p["KPUMAX"] > 0.3
    loads = [p["FZMIN"], p["FNOMIN"], p["FZMAX"]]
    assert loads[0] < 0.5 * loads[1] and loads[2] > 1.5 * loads[1], loads
    side = ct * tan(camber)  # the side force that was ridden
    x, y, beyond = Worst(), Worst(), Worst()
    for load in loads:
        extra = load / p["FNOMIN"] - 1
        stiffer = 1 + gain * extra
        for slip in steps(p["KPUMIN"], p["KPUMAX"], 201):
            x.see(tyre.forces(slip, 0.0, 0.0, load)[0] / load, friction_x(stiffer * slip, extra))
    for load in [0.4 * p["FNOMIN"], p["FNOMIN"], 1.8 * p["FNOMIN"]]:
        extra = load / p["FNOMIN"] - 1
        for worst, gammas, alphas, most in (
            (y, camber, angle, side),
            (beyond, p["CAMMAX"], p["ALPMAX"], p["PDX1"]),
        ):
            for gamma in steps(-gammas, gammas, 61):
                for alpha in steps(-alphas, alphas, 41):
                    wanted = friction_y(alpha, gamma, extra)
                    if abs(wanted) <= most:
                        worst.see(tyre.forces(0.0, alpha, gamma, load)[1] / load, wanted)
    said = {"Fx": x.share(), "Fy": y.share(), "points": x.points + y.points}
    said["beyond"] = {"Fy": beyond.share(), **behaves(tyre)}
    in_tables = {}
    with open(tables, encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            at = [float(row[k]) for k in ("slip_ratio_1", "slip_angle_rad", "camber_rad", "load_N")]
            # combined slip is never ridden: compared where each slip by itself was
            alone = abs(friction_y(at[1], at[2], at[3] / p["FNOMIN"] - 1)) <= side
            compared = row["ridden"] == "1" or row["table"] == "combined" and alone
            if row["tyre"] != end or not compared:
                continue
            for name, found in zip(("Fx_N", "Fy_N", "Mx_Nm", "Mz_Nm"), tyre.forces(*at)):
                worst = in_tables.setdefault(f"{row['table']} {name[:2]}", Worst())
                worst.see(found / at[3], float(row[name]) / at[3])
    said["tables"] = {name: worst.share() for name, worst in sorted(in_tables.items())}
    print(json.dumps(said))


if __name__ == "__main__":
    main(*sys.argv[1:])
