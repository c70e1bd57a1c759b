"""Reads an exported property file as its user would, and compares it with the fitted tyre.

    python3 motorcycle_tir.py TYRE.tir COEFFICIENTS.toml TABLES.csv front|rear

Nothing here comes from roadbench: the reader of the file and the motorcycle Magic Formula are
written from Pacejka (2012), Tire and Vehicle Dynamics, 3rd ed., section 11.6 and de Vries and
Pacejka (1998); the fitted tyre from the paper's eqs. 22, 28 and 39 with the coefficients of the
TOML export, and, for moments and combined slip, from the look-up tables. Prints one JSON object:
largest differences over the ranges that the file states, over the largest value there.

No package on PyPI was found that reads such a file: `pacejka` 0.1.0 evaluates four constants.
"""

import csv
import json
import sys
import tomllib
from math import atan, cos, copysign, exp, sin, tan


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


def main(tir, coefficients, tables, end):
    sections = read(tir)
    tyre = Motorcycle(sections)
    with open(coefficients, "rb") as file:
        document = tomllib.load(file)
    effects = {
        one["effect"]: one["value"]
        for one in document.get("effects", [])
        if one["place"].get(end) == "added"
    }
    at_rest = document.get("mf_d_at_rest", {}).get(end)
    friction_x, friction_y, ct = fitted(
        document[end], document["ranges"][end], at_rest, effects
    )
    gain = document[end]["slip_stiffness_load"]["value"]
    p = tyre.p
    loads = [p["FZMIN"], p["FNOMIN"], p["FZMAX"]]
    x, y = Worst(), Worst()
    for load in loads:
        extra = load / p["FNOMIN"] - 1
        for slip in steps(p["KPUMIN"], p["KPUMAX"], 201):
            stiffer = 1 + gain * extra
            x.see(tyre.forces(slip, 0.0, 0.0, load)[0] / load, friction_x(stiffer * slip, extra))
        for gamma in steps(p["CAMMIN"], p["CAMMAX"], 61):
            for alpha in steps(p["ALPMIN"], p["ALPMAX"], 41):
                wanted = friction_y(alpha, gamma, extra)
                if abs(wanted) <= ct * tan(p["CAMMAX"]):  # the side force that was ridden
                    y.see(tyre.forces(0.0, alpha, gamma, load)[1] / load, wanted)
    said = {"Fx": x.share(), "Fy": y.share(), "points": x.points + y.points}
    in_tables = {}
    with open(tables, encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            if row["tyre"] != end or row["ridden"] != "1":
                continue
            at = [float(row[k]) for k in ("slip_ratio_1", "slip_angle_rad", "camber_rad", "load_N")]
            for name, found in zip(("Fx_N", "Fy_N", "Mx_Nm", "Mz_Nm"), tyre.forces(*at)):
                worst = in_tables.setdefault(f"{row['table']} {name[:2]}", Worst())
                worst.see(found / at[3], float(row[name]) / at[3])
    said["tables"] = {name: worst.share() for name, worst in sorted(in_tables.items())}
    print(json.dumps(said))


if __name__ == "__main__":
    main(*sys.argv[1:])
