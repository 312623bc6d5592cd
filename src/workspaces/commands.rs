//! Commands as data: name, keys and requirement stand in one place, from which menus, palette, buttons and shortcuts
//! are made.
//!
//! Every workspace has an enum of its own commands with a table; the window has [`FrameCommand`], whose commands mean
//! something in every workspace. [`Command`] is any of them, without its type.

use egui::{Key, KeyboardShortcut, Modifiers};
use render::view::StandardView;

/// Name, keys and requirement of a command.
#[derive(Debug, PartialEq)]
pub struct CommandInfo {
    /// Name of the command.
    pub name: &'static str,
    /// Keyboard shortcut.
    pub keys: Option<KeyboardShortcut>,
    /// Reason why the command cannot be run now, where that is not plain to see.
    pub needs: Option<&'static str>,
}

impl CommandInfo {
    /// A command without keys.
    pub const fn new(name: &'static str) -> Self {
        Self { name, keys: None, needs: None }
    }

    /// Adds a shortcut of one key.
    pub const fn key(self, key: Key) -> Self {
        Self { keys: Some(KeyboardShortcut::new(Modifiers::NONE, key)), ..self }
    }

    /// Adds a shortcut of Ctrl and this key.
    pub const fn ctrl(self, key: Key) -> Self {
        Self { keys: Some(KeyboardShortcut::new(Modifiers::COMMAND, key)), ..self }
    }

    /// Adds a shortcut of Ctrl, Shift and this key.
    pub const fn ctrl_shift(self, key: Key) -> Self {
        let both = Modifiers { shift: true, ..Modifiers::COMMAND };
        Self { keys: Some(KeyboardShortcut::new(both, key)), ..self }
    }

    /// Adds the reason that is shown while the command cannot be run.
    pub const fn needing(self, why: &'static str) -> Self {
        Self { needs: Some(why), ..self }
    }

    /// Whether text fields and sliders need the keys themselves.
    fn yields_to_focus(&self) -> bool {
        self.keys.is_some_and(|s| {
            s.modifiers == Modifiers::NONE && !matches!(s.logical_key, Key::F5 | Key::F6 | Key::F7 | Key::F8)
        })
    }

    /// Tooltip: the name with the shortcut.
    pub fn hint(&self, ctx: &egui::Context) -> String {
        match self.keys {
            Some(keys) => format!("{}  ({})", self.name, ctx.format_shortcut(&keys)),
            None => self.name.to_owned(),
        }
    }
}

/// Owner of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The window.
    Frame,
    /// The switch from workspace to workspace.
    Switch,
    /// The workspace with this name in files.
    Workspace(&'static str),
}

/// A command of the window or of a workspace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Owner of the command.
    pub scope: Scope,
    /// Number in the table of its scope.
    pub index: usize,
    /// Name, keys and requirement of the command.
    pub info: &'static CommandInfo,
}

impl Command {
    /// The command that shows workspace number `index`.
    pub fn switch(index: usize, info: &'static CommandInfo) -> Self {
        Self { scope: Scope::Switch, index, info }
    }
}

/// Commands with a table of their own.
pub trait CommandSet: Copy + PartialEq + 'static {
    /// Owner of the commands.
    const SCOPE: Scope;

    /// All commands of the set, in the order of the palette.
    fn table() -> &'static [(Self, CommandInfo)];

    /// The command without its type.
    fn command(self) -> Command {
        static UNNAMED: CommandInfo = CommandInfo::new("");
        let found = Self::table().iter().enumerate().find(|(_, (command, _))| *command == self);
        let (index, info) = found.map_or((usize::MAX, &UNNAMED), |(index, (_, info))| (index, info));
        Command { scope: Self::SCOPE, index, info }
    }

    /// The typed command, if `command` belongs to this set.
    fn of(command: Command) -> Option<Self> {
        let is_one = command.scope == Self::SCOPE;
        Self::table().get(command.index).filter(|_| is_one).map(|(command, _)| *command)
    }

    /// All commands of the set without their type.
    fn all() -> Vec<Command> {
        let numbered = Self::table().iter().enumerate();
        numbered.map(|(index, (_, info))| Command { scope: Self::SCOPE, index, info }).collect()
    }

    /// A group of commands of the set, for a menu.
    fn group(all: &[Self]) -> Vec<Command> {
        all.iter().map(|command| command.command()).collect()
    }

    /// Tooltip: the name with the shortcut.
    fn hint(self, ctx: &egui::Context) -> String {
        self.command().info.hint(ctx)
    }
}

impl<C: CommandSet> From<C> for Command {
    fn from(command: C) -> Self {
        command.command()
    }
}

/// Groups of commands for a menu, separated by lines.
pub type Groups = Vec<Vec<Command>>;

/// An object that commands act on.
pub trait Commanded {
    /// Whether `command` can be run now.
    fn is_enabled(&self, command: Command) -> bool;

    /// Reason why `command`, which is not enabled, cannot be run now, with the remedy; none where it is of no interest.
    fn why_not(&self, command: Command) -> Option<&'static str> {
        command.info.needs
    }
}

/// Commands that mean something in every workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // The table names them.
pub enum FrameCommand {
    Open,
    Reload,
    Save,
    SaveAs,
    Undo,
    Redo,
    Cancel,
    Export,
    Play,
    NextNode,
    PreviousNode,
    FirstNode,
    LastNode,
    Fit,
    View(StandardView),
    Projection,
    Screenshot,
    Study,
    Theme,
    Preferences,
    Log,
    Palette,
    About,
    Quit,
}

impl CommandSet for FrameCommand {
    const SCOPE: Scope = Scope::Frame;

    fn table() -> &'static [(Self, CommandInfo)] {
        use FrameCommand as C;
        use StandardView as V;
        const fn info(name: &'static str) -> CommandInfo {
            CommandInfo::new(name)
        }
        static TABLE: [(C, CommandInfo); 30] = [
            (C::Open, info("Open…").ctrl(Key::O)),
            (C::Reload, info("Reload meshes").ctrl(Key::R)),
            (C::Save, info("Save").ctrl(Key::S)),
            (C::SaveAs, info("Save as…").ctrl_shift(Key::S)),
            (C::Undo, info("Undo").ctrl(Key::Z)),
            (C::Redo, info("Redo").ctrl_shift(Key::Z)),
            (C::Cancel, info("Cancel").key(Key::Escape)),
            (C::Export, info("Export…").ctrl(Key::E)),
            (C::Play, info("Play or pause").key(Key::Space)),
            (C::NextNode, info("Next node").key(Key::ArrowRight)),
            (C::PreviousNode, info("Previous node").key(Key::ArrowLeft)),
            (C::FirstNode, info("To the first node").key(Key::Home)),
            (C::LastNode, info("To the final pose").key(Key::End)),
            (C::Fit, info("Fit all").key(Key::F)),
            (C::Projection, info("Perspective or orthographic").key(Key::P)),
            (C::Screenshot, info("Save picture…")),
            (C::Study, info("Study…")),
            (C::Theme, info("Dark or light")),
            (C::Preferences, info("Preferences…").ctrl(Key::Comma)),
            (C::Log, info("Log").ctrl(Key::L)),
            (C::Palette, info("Commands…").ctrl(Key::K)),
            (C::About, info("About Sparkpath")),
            (C::Quit, info("Quit").ctrl(Key::Q)),
            (C::View(V::Front), info("View front").key(Key::Num1)),
            (C::View(V::Back), info("View back")),
            (C::View(V::Left), info("View left")),
            (C::View(V::Right), info("View right").key(Key::Num3)),
            (C::View(V::Top), info("View top").key(Key::Num7)),
            (C::View(V::Bottom), info("View bottom")),
            (C::View(V::Isometric), info("View isometric").key(Key::Num0)),
        ];
        &TABLE
    }
}

/// The commands among `commands` whose keys were pressed. `taken` tells that another widget takes keys without Ctrl.
pub fn pressed(ctx: &egui::Context, mut commands: Vec<Command>, taken: bool) -> Vec<Command> {
    let typing = taken || ctx.egui_wants_keyboard_input() || egui::Popup::is_any_open(ctx);
    // More modifiers first: Ctrl+Shift+S must not be taken for Ctrl+S.
    commands.retain(|c| c.info.keys.is_some() && !(typing && c.info.yields_to_focus()));
    commands.sort_by_key(|c| c.info.keys.map(|s| std::cmp::Reverse(s.modifiers.shift)));
    ctx.input_mut(|input| {
        commands.into_iter().filter(|c| c.info.keys.is_some_and(|s| input.consume_shortcut(&s))).collect()
    })
}
