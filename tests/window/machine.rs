//! The machine with its bodies: seen as soon as it is chosen, in every moment of its whole motion, and where it collides.

use egui::Key;
use egui_kittest::kittest::Queryable as _;
use feed::simulation::Phase;
use files::AnyDocument as _;
use glam::DVec3;
use render::scene::Object;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::BliskWorkspace;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::scene::{Layer, layer_of};
use sparkpath::workspaces::preferences::ThemeChoice;
use task::State;

use crate::common::easy_blisk;
use crate::desk::{Desk, Home};

/// Half the edges of the post that is in the way, and its middle, from the seat of the bed (mm).
const POST: [[f64; 3]; 2] = [[4.0, 4.0, 100.0], [70.0, 18.0, 50.0]];

/// A machine that is all right but for a post on its bed where the chuck comes by.
fn machine_with_a_post(home: &Home) -> String {
    let [half, centre] = POST;
    let size = half.map(|h| 2.0 * h);
    let post = format!(
        "[[bodies]]\nname = \"post\"\ncarried_by = \"bed\"\nshape = \"box\"\nsize_mm = {size:?}\ncentre_mm = {centre:?}\n"
    );
    let file = home.path("mine.toml");
    std::fs::write(&file, std::fs::read_to_string("assets/machines/xyzac.toml").unwrap() + &post).unwrap();
    file.to_str().unwrap().to_owned()
}

fn bodies(desk: &Desk) -> Vec<Object> {
    let is_body = |o: &&Object| layer_of(o.id) == Some(Layer::Machine);
    desk.app().scene().objects.iter().filter(is_body).cloned().collect()
}

/// Waits until all is done, and looks in every frame whether the plan passes for a good one before it is checked.
fn until_checked(desk: &mut Desk) {
    desk.until("the machine is checked", |desk| {
        let checked = matches!(desk.state(Stage::Verify), State::Failed(_));
        assert!(checked || !desk.step_says(Stage::Plan, "done"), "nothing is known of the machine yet");
        checked
    });
    desk.until_idle();
}

#[test]
fn a_machine_is_seen_from_its_choice_to_its_collision() {
    let home = Home::new();
    let project = home.project(&easy_blisk(), |job| {
        job.electrode.circumferential_reduction_deg = [3.0, 3.0];
        // Few nodes: the whole motion is simulated four times.
        job.plan.step_mm = 2.4;
    });
    let mut desk = home.start(Opening::File(project));
    desk.until_idle();
    assert!(bodies(&desk).is_empty(), "no machine is chosen");
    let machine = machine_with_a_post(&home);
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.take_machine(machine.as_ref(), cx));
    desk.until("the machine is seen", |d| !bodies(d).is_empty());
    let chosen = bodies(&desk);
    assert!(chosen.len() > 3 && desk.blisk().work.plan().is_none(), "before anything is planned");
    desk.window.get_by_label("Show Machine").click();
    desk.settle();
    assert!(bodies(&desk).is_empty());
    desk.window.get_by_label("Show Machine").click();
    desk.settle();
    assert_eq!(bodies(&desk).len(), chosen.len());

    desk.until_idle();
    desk.key(Key::F5);
    until_checked(&mut desk);
    // Nobody has touched the strip of the whole motion.
    let core = desk.blisk();
    assert!(core.moment().is_none() && core.outcome().unwrap().plan.is_verified() && !core.work.can_release());
    assert_eq!(bodies(&desk).len(), chosen.len());
    assert!(bodies(&desk).iter().any(|body| body.colour != chosen[0].colour), "what is in the way is marked");
    assert!(desk.step_says(Stage::Plan, "not safe") && desk.step_says(Stage::Verify, "failed"));
    desk.assert_shows("COLLISION: ");
    the_collision(&mut desk);
    the_whole_motion(&mut desk);
    stale_and_opened_again(&mut desk, &home);
}

/// The mark is where the bodies meet, on the surface of the post that the chuck runs into.
fn the_collision(desk: &mut Desk) {
    desk.press("Go to the collision");
    let core = desk.blisk();
    let moment = core.moment().unwrap();
    desk.assert_shows(&format!("{}, channel {}", moment.phase.name(), moment.channel));
    let [half, centre] = POST.map(DVec3::from_array);
    let post = bodies(desk).into_iter().find(|b| {
        let bounds = b.mesh.bounds();
        (bounds.size() - 2.0 * half).length() < 1e-3 && (bounds.center() - centre).length() < 1e-3
    });
    let post = post.unwrap();
    let mark = desk.app().scene().markers.iter().map(|m| post.transform.inverse().transform_point3(m.at) - centre);
    let off = mark.map(|p| ((p.abs() - half).max_element()).abs()).fold(f64::INFINITY, f64::min);
    assert!(off < 0.01, "the mark is {off} mm off the post");
    desk.open_step(Stage::Verify);
    desk.window.state_mut().context_mut().preferences.theme = ThemeChoice::Dark;
    desk.press("Fit");
    desk.picture("machine_dark");
    desk.key(Key::End);
    assert!(desk.blisk().moment().is_none(), "the timeline above has the word again");
}

/// Panels and cursors are in the moment that is shown: on the feed where the electrode is, else nowhere.
fn the_whole_motion(desk: &mut Desk) {
    let mut seen = Vec::new();
    for way in (0..500).step_by(10) {
        desk.blisk_mut().go_to_moment(f64::from(way));
        let core = desk.blisk();
        let moment = core.moment().unwrap();
        // A withdrawal is a motion of X.
        match core.feed_cursor() {
            Some(s) => assert!((moment.pose.x.abs() - s).abs() < 1e-6 && core.cursor.s == s, "{moment:?}"),
            None => assert!(moment.phase != Phase::Feed, "{moment:?}"),
        }
        assert_eq!(core.feed_cursor(), moment.s);
        if seen.contains(&moment.phase) {
            continue;
        }
        seen.push(moment.phase);
        desk.settle();
        desk.assert_shows(&moment.name());
        desk.assert_shows(&format!("{:.4}", moment.pose.x));
        let on_feed = desk.shows("from the final pose") || desk.shows("between nodes");
        assert_eq!(on_feed, moment.s.is_some(), "{moment:?}");
    }
    assert!(
        seen.contains(&Phase::Approach) && seen.contains(&Phase::Feed) && seen.contains(&Phase::Retract),
        "{seen:?}"
    );
    desk.blisk_mut().go_to_moment(0.0);
    desk.settle();
    desk.picture("moment_dark");
    desk.key(Key::End);
}

/// A stale answer still says that it was a collision; an opened project is checked before it counts.
fn stale_and_opened_again(desk: &mut Desk, home: &Home) {
    let project = home.path("machine.sparkpath");
    desk.blisk_mut().document.save_as(&project).unwrap();
    let core = desk.blisk_mut();
    let mut job = core.document.params().clone();
    job.electrode.radial_reduction_mm += 0.2;
    core.edit("Radial reduction", job, false);
    desk.until_idle();
    desk.assert_shows("Out of date: COLLISION: ");
    assert!(desk.step_says(Stage::Plan, "out of date"));
    desk.window.state_mut().open(&project);
    until_checked(desk);
    assert!(desk.step_says(Stage::Plan, "not safe"), "{:#?}", desk.log());
}
