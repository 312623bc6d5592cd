//! The channels of the wheel by kind, below the scene tree: one entry a kind, and the channels that are not like the
//! chosen one.

use egui::{Button, Color32, RichText, Ui};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::document::stage::Stage;
use task::State;
use wheel::channel::Channel;

/// Channels that are not like the chosen one, of which as many are listed.
const MOST_UNLIKE: usize = 6;

/// Draws them, once a channel is known.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    let failed = matches!(desk.work.state(Stage::Channel), State::Failed(_));
    let Some(found) = desk.work.channel().filter(|_| !failed).cloned() else { return };
    let (channel, chosen) = (&*found.channel, desk.document.params().blisk.options.channel);
    ui.add_space(6.0);
    ui.label(RichText::new("Channels").small().color(palette(ui).faint));
    for kind in 0..channel.kinds {
        let name = if channel.kinds == 1 { "One kind".to_owned() } else { format!("Kind {}", kind + 1) };
        let numbers = numbers_of(channel, kind);
        let text = format!("{name}: {} ({})", listed(&numbers), numbers.len());
        let to = chosen - chosen % channel.kinds + kind;
        let hint = format!("Channels that are like each other; a click chooses channel {to}");
        let colour = ui.visuals().text_color();
        if entry(ui, &text, colour, chosen % channel.kinds == kind, &hint) && chosen % channel.kinds != kind {
            choose(desk, to);
        }
    }
    let warning = palette(ui).warning;
    for unlike in channel.unlike.iter().take(MOST_UNLIKE) {
        let why = channel.difference(unlike);
        let text = format!("Channel {}: {why}", unlike.number);
        let hint = format!("Not like channel {}: {why}. A click chooses it", channel.index);
        if entry(ui, &text, warning, chosen == unlike.number, &hint) {
            choose(desk, unlike.number);
        }
    }
    if channel.unlike.len() > MOST_UNLIKE {
        let more = format!("{} more are not like channel {}", channel.unlike.len() - MOST_UNLIKE, channel.index);
        ui.label(RichText::new(more).color(warning));
    }
}

fn entry(ui: &mut Ui, text: &str, colour: Color32, is_chosen: bool, hint: &str) -> bool {
    let button = Button::selectable(is_chosen, RichText::new(text).color(colour)).wrap();
    ui.add(button).on_hover_text(hint).clicked()
}

fn choose(desk: &mut BliskDesk, number: usize) {
    desk.change_job(|job| job.blisk.options.channel = number);
}

/// Numbers of the channels of a kind.
fn numbers_of(channel: &Channel, kind: usize) -> Vec<usize> {
    (kind..channel.blades).step_by(channel.kinds.max(1)).collect()
}

/// The first numbers and the last one.
fn listed(numbers: &[usize]) -> String {
    let text = |numbers: &[usize]| numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    match numbers {
        [a, b, c, _, .., last] => format!("{}, … {last}", text(&[*a, *b, *c])),
        all => text(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    #[test]
    fn every_channel_is_of_one_kind() {
        let channel = Channel { kinds: 3, blades: 12, ..exact_channel(&ParametricBlisk::default()) };
        let mut all: Vec<usize> = (0..3).flat_map(|kind| numbers_of(&channel, kind)).collect();
        assert!((0..3).all(|kind| numbers_of(&channel, kind).iter().all(|n| n % 3 == kind)));
        all.sort_unstable();
        assert_eq!(all, (0..12).collect::<Vec<_>>());
    }

    #[test]
    fn long_lists_are_cut_in_the_middle() {
        assert_eq!(listed(&[0, 2, 4]), "0, 2, 4");
        assert_eq!(listed(&[1, 3, 5, 7]), "1, 3, 5, 7");
        assert_eq!(listed(&[1, 3, 5, 7, 9]), "1, 3, 5, … 9");
        assert_eq!(listed(&[0, 1, 2, 3, 4, 23]), "0, 1, 2, … 23");
    }
}
