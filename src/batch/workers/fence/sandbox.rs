//! What a worker gives up before it reads a log: it writes no file, starts no program and, where the logs are files of
//! this machine, reaches no network. As far as the system has the means (Landlock, seccomp: Linux); else the worker is
//! only a process of its own.

/// Allowed memory, bytes: data that the process has to itself, counted by Linux (`RLIMIT_DATA`).
pub(super) fn limit_memory(bytes: u64) {
    #[cfg(target_os = "linux")]
    {
        use rlimit::{Resource, getrlimit, setrlimit};
        let most = getrlimit(Resource::DATA).map_or(rlimit::INFINITY, |(_, hard)| hard);
        let _ = setrlimit(Resource::DATA, bytes.min(most), most);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = bytes;
}

/// Gives up rights, for good.
pub(super) fn enter(offline: bool) {
    #[cfg(target_os = "linux")]
    {
        linux::no_core_file();
        linux::read_only(offline);
        linux::no_calls(offline);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = offline;
}

/// Rights that this process still has, found by trying: no system lists them.
pub(super) fn rights() -> Vec<String> {
    let writes = tempfile::tempfile().is_ok();
    let connects = std::net::UdpSocket::bind("127.0.0.1:0").is_ok();
    let all = [(writes, "write files"), (connects, "reach the network")];
    all.into_iter().filter(|(may, _)| *may).map(|(_, what)| what.to_owned()).collect()
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeMap;

    use landlock::{ABI, Access, AccessFs, AccessNet, Ruleset, RulesetAttr};
    use rlimit::{Resource, setrlimit};
    use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};

    /// A worker that crashes leaves nothing behind.
    pub(super) fn no_core_file() {
        let _ = setrlimit(Resource::CORE, 0, 0);
    }

    /// No file is written, made, moved or removed, whatever the user may; an older kernel knows fewer of these rights.
    pub(super) fn read_only(offline: bool) {
        let rules = Ruleset::default().handle_access(AccessFs::from_write(ABI::V5));
        let rules = match offline {
            true => rules.and_then(|r| r.handle_access(AccessNet::from_all(ABI::V5))),
            false => rules,
        };
        // no rule allows any of it
        let _ = rules.and_then(|r| r.create()).and_then(|r| r.restrict_self());
    }

    /// Calls that no reader of logs needs are refused.
    pub(super) fn no_calls(offline: bool) {
        let mut calls = vec![
            libc::SYS_execve,
            libc::SYS_execveat,
            libc::SYS_ptrace,
            libc::SYS_process_vm_readv,
            libc::SYS_process_vm_writev,
            libc::SYS_mount,
            libc::SYS_umount2,
            libc::SYS_bpf,
            libc::SYS_keyctl,
            libc::SYS_kexec_load,
            libc::SYS_init_module,
            libc::SYS_finit_module,
            libc::SYS_unshare,
            libc::SYS_setns,
            libc::SYS_io_uring_setup,
        ];
        if offline {
            calls.extend([libc::SYS_socket, libc::SYS_connect, libc::SYS_bind, libc::SYS_sendto]);
        }
        let Ok(machine) = std::env::consts::ARCH.try_into() else { return };
        let rules: BTreeMap<i64, _> = calls.into_iter().map(|call| (call, Vec::new())).collect();
        let refuse = SeccompAction::Errno(libc::EPERM as u32);
        let filter = SeccompFilter::new(rules, SeccompAction::Allow, refuse, machine);
        let program = filter.and_then(TryInto::<BpfProgram>::try_into);
        if let Ok(program) = program {
            let _ = seccompiler::apply_filter(&program);
        }
    }
}
