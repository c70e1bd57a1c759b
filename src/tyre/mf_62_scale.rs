//! Scaling factors of a property file of Magic Formula 6.2.

use super::keys::Keys;

/// The scaling factors of the file; all are one unless somebody turned them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub(super) cx: f64,
    pub(super) mux: f64,
    pub(super) ex: f64,
    pub(super) kx: f64,
    pub(super) hx: f64,
    pub(super) vx: f64,
    pub(super) cy: f64,
    pub(super) muy: f64,
    pub(super) ey: f64,
    pub(super) ky: f64,
    pub(super) hy: f64,
    pub(super) vy: f64,
    pub(super) kyc: f64,
    pub(super) kzc: f64,
    pub(super) tr: f64,
    pub(super) res: f64,
    pub(super) xal: f64,
    pub(super) yka: f64,
    pub(super) vyka: f64,
    pub(super) s: f64,
    pub(super) mx: f64,
    pub(super) vmx: f64,
    pub(super) my: f64,
}

impl Scale {
    /// The file's scaling factors; 1 where it has none.
    pub(super) fn from_keys(keys: &Keys) -> Self {
        let l = |name: &str| keys.or(name, 1.0);
        Scale {
            cx: l("LCX"),
            mux: l("LMUX"),
            ex: l("LEX"),
            kx: l("LKX"),
            hx: l("LHX"),
            vx: l("LVX"),
            cy: l("LCY"),
            muy: l("LMUY"),
            ey: l("LEY"),
            ky: l("LKY"),
            hy: l("LHY"),
            vy: l("LVY"),
            kyc: l("LKYC"),
            kzc: l("LKZC"),
            tr: l("LTR"),
            res: l("LRES"),
            xal: l("LXAL"),
            yka: l("LYKA"),
            vyka: l("LVYKA"),
            s: l("LS"),
            mx: l("LMX"),
            vmx: l("LVMX"),
            my: l("LMY"),
        }
    }
}
