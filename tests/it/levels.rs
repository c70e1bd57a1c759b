//! Effects that sessions share: reported for the motorcycle, the site or the night that has them.

use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::levels::{Member, Pooling};
use roadbench::internals::diagnose::road::diagnose;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate;
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::plan::{Plan, PlanKind};
use roadbench::internals::simulate::transients::Transients;

const GRADE: f64 = 0.006;
const LATE: f64 = 0.03;

/// Two motorcycles on two sites over three nights: the second one's velocity is late, the first site slopes.
#[test]
fn a_late_sensor_is_the_motorcycles_and_a_slope_the_sites() {
    let names = ["road_grade", "latency", "steer_zero", "roll_zero"];
    let effects: Vec<Effect> = names.map(|n| *Effect::named(n).expect("known")).to_vec();
    let settings = Settings { nulls: 8, effects, advise: false };
    let mut pooling = Pooling::default();
    for k in 0..6 {
        let (late, slopes) = (k % 2 == 1, k / 3 == 0);
        let hidden = [("latency", late, LATE), ("road_grade", slopes, GRADE)]
            .into_iter()
            .filter(|(_, there, _)| *there)
            .map(|(name, _, size)| (Effect::named(name).expect("known"), size))
            .collect();
        let case = Case {
            seed: 0,
            number: 2 + k % 2,
            kind: Kind::Single,
            plan: "paper",
            hidden,
            foreign: None,
            odd: Vec::new(),
        };
        let (mut scenario, machine) = case.machine().expect("scenario");
        scenario.plans = vec![Plan {
            kind: PlanKind::Paper,
            coasts: 12,
            brakings: 3,
            laps: 8,
            transients: Transients::default(),
        }];
        let ridden = simulate::session_with(&scenario, &machine, k, |_| Vec::new());
        let mut session = ridden.session;
        session.meta.session_id = format!("s{k}");
        session.meta.bike_id = ["a", "b"][k % 2].to_owned();
        session.meta.site = Some(if slopes { "x" } else { "y" }.to_owned());
        // neither the motorcycles' nor the sites' sessions share a night
        let night = 1 + k % 3;
        session.meta.start_time = Some(format!("2026-05-0{night}T10:00:00Z"));
        let found =
            diagnose(&session, &machine.bike, &Pipeline::onroad(), &settings).expect("diagnosed");
        let member = Member { ident: found.ident, site: found.circumstances.site, sound: true };
        pooling.add(member, &found.causes);
    }
    let rows = pooling.rows();
    let told: Vec<_> =
        rows.iter().map(|r| (r.effect.as_str(), r.level.as_str(), r.value)).collect();
    let of = |effect: &str| rows.iter().filter(|r| r.effect == effect).collect::<Vec<_>>();
    let [late] = of("latency")[..] else { panic!("{told:?}") };
    let [slope] = of("road_grade")[..] else { panic!("{told:?}") };
    assert_eq!(rows.len(), 2, "{told:?}");
    assert_eq!(late.level, "bike", "{told:?}");
    assert_eq!((slope.level.as_str(), slope.pooled_over.as_deref()), ("site", Some("x")));
    for (row, truth) in [(late, LATE), (slope, GRADE)] {
        let (low, high) = (row.ci95_low.expect("low"), row.ci95_high.expect("high"));
        assert!(0.4 * truth < low && low < truth && truth < high, "{low} to {high}");
    }
}
