//! The list of workspaces: one line for each.

use super::workspace::Workspace;
use super::{blisk, flank, mold};
use task::Scheduler;

/// The workspaces in the order of the switch.
pub fn workspaces(scheduler: &Scheduler) -> Vec<Box<dyn Workspace>> {
    vec![
        Box::new(blisk::BliskWorkspace::new(scheduler)),
        Box::new(mold::MoldWorkspace::new(scheduler)),
        Box::new(flank::FlankWorkspace::new(scheduler)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::commands::{Command, CommandSet, FrameCommand};

    #[test]
    fn no_two_commands_that_can_be_given_together_share_their_keys_or_their_name() {
        let list = workspaces(&Scheduler::manual(|| ()));
        let switches = list.iter().enumerate().map(|(i, one)| Command::switch(i, &one.about().switch));
        let frame: Vec<Command> = FrameCommand::all().into_iter().chain(switches).collect();
        for workspace in &list {
            let all = [frame.clone(), workspace.commands()].concat();
            for (i, a) in all.iter().enumerate() {
                assert!(!a.info.name.is_empty(), "{a:?}");
                for b in &all[i + 1..] {
                    assert!(a.info.keys.is_none() || a.info.keys != b.info.keys, "{a:?} and {b:?}");
                    assert_ne!(a.info.name, b.info.name);
                }
            }
        }
    }

    #[test]
    fn every_workspace_has_documents_of_a_kind_of_its_own() {
        let list = workspaces(&Scheduler::manual(|| ()));
        for (i, a) in list.iter().enumerate() {
            assert_eq!(a.document().kind(), a.about().id);
            assert!(list[i + 1..].iter().all(|b| a.about().id != b.about().id));
        }
    }
}
