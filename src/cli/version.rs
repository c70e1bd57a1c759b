//! What `roadbench --version` says: which build this is, for reports of errors.

use std::sync::LazyLock;

/// Version, commit, platform, profile and features; `-V` says the first alone.
pub(super) fn long() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let profile = if cfg!(debug_assertions) { "dev" } else { "release" };
        let features = [("fleet", cfg!(feature = "fleet")), ("cloud", cfg!(feature = "cloud"))];
        let has: Vec<&str> = features.iter().filter(|f| f.1).map(|f| f.0).collect();
        let libc = match cfg!(target_os = "linux") {
            true if cfg!(target_env = "musl") => " (static)",
            _ => "",
        };
        // the release workflow sets it; nothing is asked of git where there may be none
        let commit = option_env!("ROADBENCH_COMMIT").unwrap_or("unknown");
        let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
        let features = if has.is_empty() { "none".to_owned() } else { has.join(", ") };
        format!(
            "{}\ncommit    {commit}\nplatform  {system} {machine}{libc}\nprofile   {profile}\nfeatures  {features}",
            crate::VERSION
        )
    });
    &TEXT
}
