//! What is worth having first where some things must come before others.
//!
//! Each job gains something once it is done, takes a while, and may have one before it. The order that
//! makes the gains come earliest (the least sum of gain times completion) is known (Horn, 1972): a job
//! that gains more a while than the one before it can only wait for that one, so both are one
//! job; what is left goes by gain over time.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Job {
    /// What it gains.
    pub(super) gain: f64,
    /// What it takes, > 0.
    pub(super) cost: f64,
    /// Index of the one before it, smaller than its own.
    pub(super) after: Option<usize>,
}

/// The indices of the jobs in the order in which their gains come earliest. Equal ones keep theirs.
pub(super) fn order(jobs: &[Job]) -> Vec<usize> {
    // Of each job that heads a cluster: the cluster as one job, and what waits for any of it.
    let mut clusters: Vec<Job> = jobs.to_vec();
    let mut waiting: Vec<BinaryHeap<Waiting>> = jobs.iter().map(|_| BinaryHeap::new()).collect();
    // The jobs of a cluster are a list: which follows each, and of each head which is the last.
    let mut then: Vec<Option<usize>> = vec![None; jobs.len()];
    let mut last: Vec<usize> = (0..jobs.len()).collect();
    let mut is_head = vec![true; jobs.len()];
    for head in (0..jobs.len()).rev() {
        let mut behind = std::mem::take(&mut waiting[head]);
        let mut cluster = clusters[head];
        while let Some(next) = behind.peek().filter(|next| next.rate > cluster.rate()).copied() {
            behind.pop();
            cluster.gain += clusters[next.head].gain;
            cluster.cost += clusters[next.head].cost;
            is_head[next.head] = false;
            then[last[head]] = Some(next.head);
            last[head] = last[next.head];
            // The smaller into the larger.
            let mut theirs = std::mem::take(&mut waiting[next.head]);
            if theirs.len() > behind.len() {
                std::mem::swap(&mut theirs, &mut behind);
            }
            behind.extend(theirs);
        }
        if let Some(above) = cluster.after {
            waiting[above].push(Waiting { rate: cluster.rate(), head });
        }
        (clusters[head], waiting[head]) = (cluster, behind);
    }
    let mut heads: Vec<usize> = (0..jobs.len()).filter(|&index| is_head[index]).collect();
    heads.sort_by(|&a, &b| clusters[b].rate().total_cmp(&clusters[a].rate()));
    heads.into_iter().flat_map(|head| std::iter::successors(Some(head), |&job| then[job])).collect()
}

impl Job {
    fn rate(&self) -> f64 {
        self.gain / self.cost
    }
}

/// A cluster that waits for another job.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    rate: f64,
    head: usize,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rate.total_cmp(&other.rate).then(other.head.cmp(&self.head))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Sum of gain times completion of the jobs in this order.
    fn lateness(jobs: &[Job], order: &[usize]) -> f64 {
        let (mut time, mut sum) = (0.0, 0.0);
        for &index in order {
            time += jobs[index].cost;
            sum += time * jobs[index].gain;
        }
        sum
    }

    /// The least lateness of all orders in which nothing comes before what is before it.
    fn least(jobs: &[Job], done: &mut Vec<usize>) -> f64 {
        if done.len() == jobs.len() {
            return lateness(jobs, done);
        }
        let mut least_so_far = f64::INFINITY;
        for index in 0..jobs.len() {
            let is_free = jobs[index].after.is_none_or(|above| done.contains(&above));
            if is_free && !done.contains(&index) {
                done.push(index);
                least_so_far = least_so_far.min(least(jobs, done));
                done.pop();
            }
        }
        least_so_far
    }

    fn forest() -> impl Strategy<Value = Vec<Job>> {
        let job = (0.0..10.0f64, 0.1..10.0f64, any::<prop::sample::Index>(), any::<bool>());
        prop::collection::vec(job, 1..7).prop_map(|jobs| {
            let mut made: Vec<Job> = Vec::new();
            for (gain, cost, above, free) in jobs {
                let after = (!free && !made.is_empty()).then(|| above.index(made.len()));
                made.push(Job { gain, cost, after });
            }
            made
        })
    }

    proptest! {
        #[test]
        fn no_other_order_gains_earlier(jobs in forest()) {
            let order = order(&jobs);
            for (place, &index) in order.iter().enumerate() {
                let above = jobs[index].after;
                prop_assert!(above.is_none_or(|above| order[..place].contains(&above)));
            }
            let (found, best) = (lateness(&jobs, &order), least(&jobs, &mut Vec::new()));
            prop_assert!(found <= best * (1.0 + 1e-12) + 1e-9, "{found} {best} {order:?}");
        }
    }

    #[test]
    fn a_long_chain_is_no_deep_recursion() {
        let job = |index: usize| Job { gain: index as f64, cost: 1.0, after: index.checked_sub(1) };
        let jobs: Vec<Job> = (0..100_000).map(job).collect();
        assert!(order(&jobs).is_sorted(), "each waits for the one before it");
    }
}
