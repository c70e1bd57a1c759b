//! What options may be, as the command line names and explains it; the rooms have the same enums without its words.

use crate::report;
use crate::report::export::written;
use crate::report::static_figures::write;

/// An enum of the command line with the variants of a room's.
macro_rules! choice {
    ($(#[$doc:meta])* $name:ident of $room:ty { $($(#[$words:meta])* $variant:ident,)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
        pub(crate) enum $name {
            $($(#[$words])* $variant,)+
        }

        impl From<$name> for $room {
            fn from(choice: $name) -> Self {
                type Room = $room;
                match choice {
                    $($name::$variant => Room::$variant,)+
                }
            }
        }
    };
}

choice! {
    /// Of `--pages`.
    #[derive(Default)]
    PageKind of report::Pages {
        /// Self-contained up to 50 sessions, shared above, on demand above 1000; pages that are there stay
        /// as they are.
        #[default]
        Auto,
        /// Each page is one file that opens wherever it is.
        SelfContained,
        /// Script and style once in `assets`, beside the pages.
        Shared,
        /// Of a session only those that are there; `report --open` writes one more.
        OnDemand,
        /// Of the run, the fleet and diagnoses alone, none of a session.
        None,
    }
}

choice! {
    /// Of `--figure-format`.
    #[derive(Default)]
    FigureFormat of write::Format {
        /// Lines and letters that stay sharp at any size and can be edited.
        #[default]
        Svg,
        /// Pixels, for what takes no SVG.
        Png,
        /// One file of each.
        Both,
    }
}

choice! {
    /// Of `export --format`.
    TyreFormat of written::Format {
        /// Magic Formula property file.
        Tir,
        /// Coefficients with intervals, status and ranges.
        Toml,
        /// Look-up tables of forces and moments.
        Csv,
        /// C99 header that evaluates the tyre.
        C,
        /// Simulation unit of FMI 3.0 with sources in C; a zip archive.
        Fmu,
        /// TYDEX file of what a bench would measure of it.
        Tydex,
        /// The tyre as `roadbench simulate --front-tyre` and `--rear-tyre` take it.
        Simulator,
    }
}

choice! {
    /// Of `export --set`.
    CoefficientSet of written::Set {
        /// Motorcycle Magic Formula 5.2 (FITTYP 52, PAC_MC), fitted over the ridden camber.
        #[value(name = "5.2", alias = "motorcycle")]
        Motorcycle,
        /// Magic Formula 6.2 (FITTYP 62), fitted over the ridden camber, known to more readers.
        #[value(name = "6.2")]
        MagicFormula62,
        /// A few coefficients of Magic Formula 6.2 in closed form: right at small angles.
        Reduced,
    }
}

choice! {
    /// Of `export --tyre`.
    Tyre of written::Tyre {
        /// The front one.
        Front,
        /// The rear one.
        Rear,
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    /// The names of some choices, in their order, and what each is.
    fn names<C: ValueEnum + Into<R>, R>() -> Vec<(String, R)> {
        let named = |choice: &C| {
            let name = choice.to_possible_value()?.get_name().to_owned();
            Some((name, choice.clone().into()))
        };
        C::value_variants().iter().filter_map(named).collect()
    }

    /// `roadbench.export` of Python takes the words of the command line.
    #[test]
    fn choices_are_called_as_in_the_library() {
        fn check<C: ValueEnum + Into<R>, R: Copy + PartialEq + std::fmt::Debug>(
            room: &[(&str, R)],
        ) {
            let room: Vec<(String, R)> =
                room.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            assert_eq!(names::<C, R>(), room);
        }
        check::<TyreFormat, _>(written::Format::NAMES);
        check::<CoefficientSet, _>(written::Set::NAMES);
        check::<Tyre, _>(written::Tyre::NAMES);
    }
}
