//! Times of the window: laying out a frame, drawing apart, while nothing happens and while a plan runs.
//!
//! `take_slowest_frame` measures what the window itself does in a frame, on the clock of the thread that draws. A
//! frame of 60 a second has 16.7 ms for that and for drawing.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use egui::vec2;
use egui_kittest::Harness;
use sparkpath::shell::run::{Opening, SparkpathApp};
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::{BliskDesk, BliskWorkspace};
use task::State;

type Window = Harness<'static, SparkpathApp>;

fn window() -> Window {
    let mut window = Harness::builder()
        .with_size(vec2(1440.0, 900.0))
        .wgpu()
        .build_eframe(|cc| SparkpathApp::new(cc, &Opening::Demonstration, None).expect("a graphics driver"));
    while desk(&window).work.state(Stage::Plan) != State::Ready {
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    window.run_steps(4);
    window
}

fn desk(window: &Window) -> &BliskDesk {
    &window.state().workspace::<BliskWorkspace>().expect("the workspace of blisks").desk
}

fn desk_mut(window: &mut Window) -> &mut BliskDesk {
    &mut window.state_mut().workspace_mut::<BliskWorkspace>().expect("the workspace of blisks").desk
}

/// Starts a plan of the demonstration with a seed of its own, so that none is like another.
fn start_plan(window: &mut Window, seed: u64) {
    let core = desk_mut(window);
    let mut job = core.document.params().clone();
    job.genetic.seed = seed;
    core.edit("Seed", job, false);
    // The frame in which the window takes note of it.
    window.step();
    while !desk(window).can_plan() {
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    desk_mut(window).work.start_plan().expect("the electrode is made");
}

fn is_planning(window: &Window) -> bool {
    desk(window).work.state(Stage::Plan) == State::Running
}

/// Lays out one frame and answers what the window itself took for it.
fn frame(window: &mut Window) -> Duration {
    window.state_mut().take_slowest_frame();
    window.step();
    Duration::from_secs_f64(window.state_mut().take_slowest_frame())
}

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("window");
    group.sample_size(20);
    let window = RefCell::new(window());
    group.bench_function("frame, nothing happens", |b| {
        b.iter_custom(|n| (0..n).map(|_| frame(&mut window.borrow_mut())).sum());
    });
    group.bench_function("frame, cursor moves along the path", |b| {
        b.iter_custom(|n| {
            let mut window = window.borrow_mut();
            let length = desk(&window).track().length();
            let mut total = Duration::ZERO;
            for i in 0..n {
                desk_mut(&mut window).go_to(length * (i % 50) as f64 / 50.0);
                total += frame(&mut window);
            }
            total
        });
    });
    group.bench_function("frame, a plan runs", |b| {
        let mut seed = 1;
        b.iter_custom(|n| {
            let mut window = window.borrow_mut();
            let mut total = Duration::ZERO;
            for _ in 0..n {
                while !is_planning(&window) {
                    seed += 1;
                    start_plan(&mut window, seed);
                    window.step();
                }
                total += frame(&mut window);
            }
            total
        });
    });
    group.finish();
    slowest_while_planning(&mut window.borrow_mut());
}

/// What this thread has spent on a processor, as Linux counts it: unlike the time that has gone by, it knows nothing
/// of other programs. It is counted in ticks of a few milliseconds.
fn on_processor() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

/// The slowest frame of a whole plan at the pace of a screen: what a mean hides.
fn slowest_while_planning(window: &mut Window) {
    start_plan(window, 1_000);
    window.step();
    let (started, mut times, mut on_processor_most) = (Instant::now(), Vec::new(), Duration::ZERO);
    while is_planning(window) && started.elapsed() < Duration::from_secs(60) {
        let before = on_processor();
        times.push(frame(window));
        if let (Some(before), Some(after)) = (before, on_processor()) {
            on_processor_most = on_processor_most.max(after - before);
        }
        std::thread::sleep(Duration::from_millis(16));
    }
    times.sort();
    let at = |share: f64| times.get((share * (times.len() as f64 - 1.0)) as usize).copied().unwrap_or_default();
    println!(
        "window/frames of a whole plan: {} in {:.1} s, median {:.2?}, 99 of 100 within {:.2?}, slowest {:.2?}, of which at \
         most {on_processor_most:.2?} on a processor in any frame",
        times.len(),
        started.elapsed().as_secs_f64(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

criterion_group!(benches, frames);
criterion_main!(benches);
