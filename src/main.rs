//! The program: see [`sparkpath::cli`].

fn main() -> std::process::ExitCode {
    quieten_driver();
    sparkpath::cli::run()
}

/// Keeps standard error for our own lines. Where `XDG_RUNTIME_DIR` is not set there is no Wayland, but a layer of
/// Mesa's Vulkan drivers looks for it all the same and complains; it is told to stay away.
fn quieten_driver() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is the only thread as yet, so that nobody reads the environment at the same time.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
