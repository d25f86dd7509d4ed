//! The options of constrained synthesis as a run used them.

use serde_json::Value;

use super::frames::SequenceArgs;
use super::job::Job;
use crate::loom::Loom;
use crate::used::Used;

impl Job<'_> {
    /// The options as used.
    pub(super) fn used(&self, loom: &Loom<'_>) -> Used {
        let (knobs, options) = (self.knobs, &self.options);
        let turn = knobs.turning(self.task).turn;
        let used = if self.task.turn {
            loom.used().set("no-turn", !turn).without("turn")
        } else {
            loom.used().set("turn", turn).without("no-turn")
        };
        let used = used
            .set("constraint-weight", options.constraint_weight)
            .set("neighborhood", options.neighborhood)
            .set("spread", options.spread)
            .set("levels", options.levels)
            .unless("tolerance", Value::Null)
            .unless("kernel", "box")
            .unless("spread", 0.0)
            .unless("levels", Value::Null)
            .unless("auto-guides", Value::Null)
            .unless("follow-where", Value::Null)
            .unless("start", Value::Null)
            .unless("over", Value::Null)
            .unless("fixed", Value::Null)
            .unless("random-labels", Value::Null);
        let used = match self.frame {
            Some(frame) => frame.used(loom, used),
            None if used.has("temporal") => SequenceArgs::idle(knobs.guides.used(loom, used)),
            None => knobs.guides.used(loom, used),
        };
        used.unless("weight", Vec::<Value>::new())
    }
}
