//! Opens the window, or explains why it cannot be opened.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, OnceLock};

use super::run::{Folders, Opening, SparkpathApp};
use crate::panic_text;
use crate::workspaces::preferences::Preferences;

/// Preconditions of a window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Window {
    /// All preconditions are met.
    Possible,
    /// There is no display or no graphics device: reason and remedy.
    Impossible(String),
}

/// Checks whether a window can be opened, before anything is tried.
pub fn preflight() -> Window {
    let named = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    let has_display = cfg!(not(all(unix, not(target_os = "macos")))) || named("DISPLAY") || named("WAYLAND_DISPLAY");
    if !has_display {
        return Window::Impossible(
            "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set): run it on a desktop, or use the \
             commands that need no window, such as `sparkpath demo --out DIR`; `sparkpath --help` lists them"
                .to_owned(),
        );
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    if pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all())).is_empty() {
        return Window::Impossible(
            "no graphics driver was found: install one, or Mesa's software renderer (Debian: apt-get install \
             mesa-vulkan-drivers libgl1-mesa-dri)"
                .to_owned(),
        );
    }
    Window::Possible
}

/// Sets the number of threads that the user prefers, unless the command line sets one.
fn take_threads() {
    let threads = Folders::of_user().map_or(0, |folders| Preferences::read(&folders.config).threads);
    if threads > 0 {
        // An error says that the threads are there already, with the number of the command line.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
}

/// Icon of the window. On Wayland the desktop takes that of the desktop entry named as the window's app id.
fn icon() -> egui::IconData {
    eframe::icon_data::from_png_bytes(include_bytes!("../../assets/desktop/sparkpath.png")).unwrap_or_default()
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// The obstacle in plain words.
pub fn run_window(opening: Opening) -> Result<(), String> {
    if let Window::Impossible(why) = preflight() {
        return Err(why);
    }
    take_threads();
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Sparkpath")
            .with_app_id("sparkpath")
            .with_icon(icon())
            .with_inner_size([1440.0, 900.0])
            // A screen of 1280 by 720 pixels at 200 %.
            .with_min_inner_size([640.0, 340.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        ..Default::default()
    };
    let ending = Arc::new(OnceLock::new());
    let told = ending.clone();
    let app = move |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>> {
        let app = SparkpathApp::new(cc, &opening, Folders::of_user())?;
        told.get_or_init(|| app.ending().clone());
        Ok(Box::new(app))
    };
    // The library of windows panics where the connection to the screen breaks.
    let run = || eframe::run_native("sparkpath", options, Box::new(app)).map_err(|error| error.to_string());
    let ended = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let is_connection = panic_text(&*panic).contains("Connection(");
        if is_connection { Err("the connection to the screen was lost".to_owned()) } else { resume_unwind(panic) }
    });
    let was_open = ending.get();
    if let Some(why) = was_open.and_then(|ending| ending.get()) {
        return Err(why.clone());
    }
    ended.map_err(|e| match was_open {
        Some(_) => format!("the window was closed by the system ({e}); unsaved work is offered at the next start"),
        None => format!(
            "the window could not be opened ({e}); the commands without a window still work, see `sparkpath --help`"
        ),
    })
}
