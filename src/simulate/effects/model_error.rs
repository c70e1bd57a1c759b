//! Generates [`ModelError`](super::ModelError) and what goes with it from the list of effects.

/// One step of a fold over the effects.
pub(super) trait Step {
    /// Value with an effect of a size.
    fn step<E: super::physics::Physics>(&self, size: f64, value: f64) -> f64;
}

/// From the list of effects: a number each, the list as data, and the hooks of all of them.
macro_rules! effects {
    ($($module:ident::$effect:ident,)*) => {
        /// Effects that a real ride may have and the nominal model has not: the size of every effect, in its unit.
        /// All are zero in the nominal model.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct ModelError {
            $(
                #[doc = concat!("Size of the effect `", stringify!($module), "`.")]
                pub $module: f64,
            )*
        }

        /// Every candidate, in the order in which their hooks are folded.
        pub const ALL: &[Effect] = &[$(Effect {
            name: stringify!($module),
            spec: $module::$effect::SPEC,
            multibody: $module::$effect::MULTIBODY,
            get: |error| error.$module,
            set: |error, size| error.$module = size,
            remove: $module::$effect::REMOVE,
            tyres: $module::$effect::TYRES,
            reach: $module::$effect::REACH,
            in_per_cent: $module::$effect::IN_PER_CENT,
        },)*];

        impl ModelError {
            #[inline(always)]
            fn fold(&self, step: impl Step, value: f64) -> f64 {
                $(let value = step.step::<$module::$effect>(self.$module, value);)*
                value
            }

            /// The sizes of those effects that attitudes depend on; the others are zero.
            pub fn of_attitude(&self) -> ModelError {
                let kept = |size: f64, keep: bool| if keep { size } else { 0.0 };
                ModelError { $($module: kept(self.$module, $module::$effect::REACH.attitude),)* }
            }

            /// The sizes of those effects that are a tyre's; the others are zero.
            pub fn of_tyre(&self, axle: Axle) -> ModelError {
                let kept = |size: f64, keep: bool| if keep { size } else { 0.0 };
                ModelError {
                    $($module: kept(self.$module, $module::$effect::TYRES.contains(&axle)),)*
                }
            }

            /// The sizes of those effects that the multibody motorcycle has from their hooks; the others are
            /// zero.
            pub fn of_hooks(&self) -> ModelError {
                let kept = |size: f64, keep: bool| if keep { size } else { 0.0 };
                ModelError {
                    $($module: kept(
                        self.$module,
                        matches!($module::$effect::MULTIBODY, Multibody::Hooks),
                    ),)*
                }
            }

            /// Whether it matters which way the motorcycle goes.
            #[inline(always)]
            pub fn needs_heading(&self) -> bool {
                false $(|| $module::$effect::NEEDS_HEADING && self.$module != 0.0)*
            }

            /// Applies sensor errors to the true channels, in place.
            pub fn measure(&self, session: &mut Session) {
                $(
                    if self.$module != 0.0 {
                        $module::$effect::measure(self.$module, session);
                    }
                )*
            }
        }
    };
}
pub(super) use effects;

/// From the list of hooks: each folded over all effects.
macro_rules! compose {
    ($($(#[$doc:meta])* fn $hook:ident($value:ident $(, $argument:ident: $kind:ty)*);)*) => {
        impl ModelError {
            $(
                $(#[$doc])*
                #[inline(always)]
                pub fn $hook(&self, $value: f64 $(, $argument: $kind)*) -> f64 {
                    struct Hook { $($argument: $kind,)* }
                    impl Step for Hook {
                        #[inline(always)]
                        fn step<E: Physics>(&self, size: f64, value: f64) -> f64 {
                            E::$hook(size, value $(, self.$argument)*)
                        }
                    }
                    self.fold(Hook { $($argument,)* }, $value)
                }
            )*
        }
    };
}
pub(super) use compose;
