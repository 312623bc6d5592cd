//! What the hands of the user do: the changes that are made meanwhile are one step.

use files::{Document, Params};

/// What the hands of the user do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Hands {
    /// The hands rest.
    #[default]
    Idle,
    /// A button of the mouse is held down: what is dragged is not at rest.
    Holding,
    /// A text is being typed.
    Typing,
}

impl Hands {
    /// The state of the hands in this frame.
    pub fn of(ctx: &egui::Context) -> Self {
        match (ctx.input(|i| i.pointer.any_down()), ctx.egui_wants_keyboard_input()) {
            (true, _) => Self::Holding,
            (false, true) => Self::Typing,
            (false, false) => Self::Idle,
        }
    }
}

/// What the hands do to a document, in this frame and the one before.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gesture {
    now: Hands,
    before: Hands,
}

impl Gesture {
    /// Notes what the hands do, once a frame; with something new the gesture before ends.
    pub fn follow<P: Params>(&mut self, hands: Hands, document: &mut Document<P>) {
        (self.before, self.now) = (self.now, hands);
        if self.before == Hands::Idle || (hands != Hands::Idle && hands != self.before) {
            document.end_gesture();
        }
    }

    /// Whether a change that is made now belongs to a gesture. The frame in which a button is let go still does.
    pub fn goes_on(self) -> bool {
        self.now != Hands::Idle || self.before != Hands::Idle
    }

    /// Whether a button of the mouse is down.
    pub fn is_holding(self) -> bool {
        self.now == Hands::Holding
    }
}
