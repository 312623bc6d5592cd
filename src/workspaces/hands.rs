//! Input activity of the user. Changes during one gesture form one step of undo.

use files::{Document, Params};

/// Input activity of the user.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Hands {
    /// No button or key is in use.
    #[default]
    Idle,
    /// A button of the mouse is held down, as in a drag.
    Holding,
    /// A text is being typed.
    Typing,
}

impl Hands {
    /// Input activity in this frame.
    pub fn of(ctx: &egui::Context) -> Self {
        match (ctx.input(|i| i.pointer.any_down()), ctx.egui_wants_keyboard_input()) {
            (true, _) => Self::Holding,
            (false, true) => Self::Typing,
            (false, false) => Self::Idle,
        }
    }
}

/// Input activity in this frame and the one before, as it concerns a document.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gesture {
    now: Hands,
    before: Hands,
}

impl Gesture {
    /// Notes the activity of a frame. A new activity ends the gesture before.
    pub fn follow<P: Params>(&mut self, hands: Hands, document: &mut Document<P>) {
        (self.before, self.now) = (self.now, hands);
        if self.before == Hands::Idle || (hands != Hands::Idle && hands != self.before) {
            document.end_gesture();
        }
    }

    /// Whether a change made now belongs to a gesture. The frame in which a button is released still belongs to it.
    pub fn goes_on(self) -> bool {
        self.now != Hands::Idle || self.before != Hands::Idle
    }

    /// Whether a button of the mouse is down.
    pub fn is_holding(self) -> bool {
        self.now == Hands::Holding
    }
}
