//! Genbuf and AMBA of any size: the scalable benchmarks of Anzu.
//!
//! The formulas come from Anzu's generators (Bloem et al., "Specify, compile, run: hardware from
//! PSL", COCV 2007, and "Automatic hardware synthesis from specifications: a case study", DATE
//! 2007). The text equals that of the published benchmark files, byte for byte.

use super::formula::{Format, Formula, Player, all, bits, number, print};

/// The genbuf benchmark: a buffer that passes data of `senders` senders through a FIFO queue to two
/// receivers.
///
/// Every handshake has four phases: request, acknowledge, and the end of both.
pub fn genbuf(senders: usize, format: Format) -> String {
    assert!(senders >= 2, "GenBuf needs at least two senders");
    let (mut env, mut sys) = (Player::default(), Player::default());

    let request = env.declare_all((0..senders).map(|i| format!("StoB_REQ{i}")));
    let received = env.declare_all((0..2).map(|j| format!("RtoB_ACK{j}")));
    let full = env.declare("FULL", false);
    let empty = env.declare("EMPTY", true);

    let accepted = sys.declare_all((0..senders).map(|i| format!("BtoS_ACK{i}")));
    let offer = sys.declare_all((0..2).map(|j| format!("BtoR_REQ{j}")));
    let waiting = sys.declare("stateG7_0", false);
    let last = sys.declare("stateG7_1", true);
    let enqueue = sys.declare("ENQ", false);
    let dequeue = sys.declare("DEQ", false);
    let pending = sys.declare("stateG12", false);
    let select = sys.declare_all((0..bits(senders)).map(|bit| format!("SLC{bit}")));

    // Handshakes with the senders. At most one sender is acknowledged.
    for i in 0..senders {
        let (request, ack) = (&request[i], &accepted[i]);
        env.always((request & !ack).implies(request.next()));
        env.always(ack.implies(!request.next()));
        sys.always((!request & request.next()).implies(!ack.next()));
        sys.always((!ack & !request).implies(!ack.next()));
        sys.always((ack & request).implies(ack.next()));
        for other in &accepted[i + 1..] {
            sys.always(!ack | !other);
        }
        sys.always_eventually(request.iff(ack));
    }

    // Handshakes with the receivers. At most one receiver gets an offer.
    for j in 0..2 {
        let (offer_j, ack) = (&offer[j], &received[j]);
        env.always((!offer_j).implies(!ack.next()));
        env.always((offer_j & ack).implies(ack.next()));
        env.always_eventually(offer_j.iff(ack));
        sys.always((offer_j & !ack).implies(offer_j.next()));
        for other in &offer[j + 1..] {
            sys.always(!offer_j | !other);
        }
        sys.always(ack.implies(!offer_j.next()));
    }
    sys.always((&offer[0] & &offer[1]).implies(Formula::False));

    // The receivers take turns. `last` is the receiver of the last offer, `waiting` means that this
    // offer has ended.
    let (first, second) = (&offer[0], &offer[1]);
    let after = |receiver: &Formula, waits: &Formula| receiver.next() & waits.next();
    let (w, l) = (&waiting, &last);
    sys.always((!l & !first & second).implies(after(l, &!w)));
    sys.always((l & first & !second).implies(after(&!l, &!w)));
    sys.always((!l & !first & !second).implies(after(&!l, w)));
    sys.always((l & !first & !second).implies(after(l, w)));
    sys.always((!l & !w & first & !second).implies(after(&!l, &!w)));
    sys.always((l & !w & !first & second).implies(after(l, &!w)));
    sys.always((!l & w & first).implies(Formula::False));
    sys.always((l & w & second).implies(Formula::False));

    // The data of a newly acknowledged sender is selected and enqueued.
    for (i, ack) in accepted.iter().enumerate() {
        let rises = !ack & ack.next();
        let selected = number(&select, i).next();
        sys.always(rises.implies(enqueue.next()));
        sys.always(if i == 0 {
            rises.implies(selected)
        } else {
            rises.iff(selected)
        });
    }
    sys.always(all(accepted.iter().map(|ack| ack | !ack.next())).implies(!enqueue.next()));

    // Data is dequeued when a receiver ends its acknowledgement.
    for ack in &received {
        sys.always((ack & !ack.next()).implies(dequeue.next()));
    }
    sys.always(all(received.iter().map(|ack| !ack | ack.next())).implies(!dequeue.next()));

    // The queue.
    env.always((&enqueue & !&dequeue).implies(!empty.next()));
    env.always((&dequeue & !&enqueue).implies(!full.next()));
    let unchanged = full.iff(full.next()) & empty.iff(empty.next());
    env.always(enqueue.iff(&dequeue).implies(unchanged));
    sys.always((&full & !&dequeue).implies(!&enqueue));
    sys.always(empty.implies(!&dequeue));

    // Data in the queue is dequeued eventually. `pending` means that there is some.
    sys.always((!&pending & &empty).implies(!pending.next()));
    sys.always((!&pending & &dequeue).implies(!pending.next()));
    sys.always((!&pending & !&empty & !&dequeue).implies(pending.next()));
    sys.always((&pending & !&dequeue).implies(pending.next()));
    sys.always((&pending & &dequeue).implies(!pending.next()));
    sys.always_eventually(!&pending);

    print(&format!("genbuf{senders}"), &env, &sys, format)
}

/// The AMBA benchmark: the arbiter of an AHB bus with `masters` masters.
///
/// Names with A and G are those of the case study's assumptions and guarantees.
pub fn amba(masters: usize, format: Format) -> String {
    assert!(masters >= 2, "AMBA needs at least two masters");
    let (mut env, mut sys) = (Player::default(), Player::default());

    let ready = env.declare("hready", false);
    let (request, lock): (Vec<_>, Vec<_>) = (0..masters)
        .map(|i| {
            (
                env.declare(format!("hbusreq{i}"), false),
                env.declare(format!("hlock{i}"), false),
            )
        })
        .unzip();
    let burst = env.declare_all((0..2).map(|bit| format!("hburst{bit}")));

    let master = sys.declare_all((0..bits(masters)).map(|bit| format!("hmaster{bit}")));
    let master_locks = sys.declare("hmastlock", false);
    let start = sys.declare("start", true);
    let decide = sys.declare("decide", true);
    let locked = sys.declare("locked", false);
    let grant: Vec<_> = (0..masters)
        .map(|i| sys.declare(format!("hgrant{i}"), i == 0))
        .collect();
    let master_requests = sys.declare("busreq", false);
    let a1 = sys.declare_all((0..2).map(|bit| format!("stateA1_{bit}")));
    let g2 = sys.declare("stateG2", false);
    let g3 = sys.declare_all((0..3).map(|bit| format!("stateG3_{bit}")));
    let g10 = sys.declare_all((1..masters).map(|i| format!("stateG10_{i}")));

    // A3: a master that locks the bus requests it.
    for (request, lock) in request.iter().zip(&lock) {
        env.always(lock.implies(request));
    }

    // `busreq` is the request of the current master.
    for (i, request) in request.iter().enumerate() {
        sys.always(number(&master, i).implies((!request).iff(!&master_requests)));
    }

    // A1: a master ends its locked burst of unspecified length. The upper bit of the state is set
    // while it has not. A2: the bus gets ready again and again.
    let other_burst = !&master_locks | &burst[0] | &burst[1];
    let open_burst = |state: Formula| state & &master_locks & !&burst[0] & !&burst[1];
    let a1_state = |value: usize| number(&[a1[1].clone(), a1[0].clone()], value);
    let (idle, burst_state, ended) = (a1_state(0), a1_state(1), a1_state(2));
    sys.always((&idle & &other_burst).implies(idle.next()));
    sys.always(open_burst(idle.clone()).implies(burst_state.next()));
    sys.always((&burst_state & &master_requests).implies(burst_state.next()));
    let released = &burst_state & !&master_requests;
    sys.always((&released & &other_burst).implies(idle.next()));
    sys.always(open_burst(released).implies(ended.next()));
    sys.always((&ended & &master_requests).implies(burst_state.next()));
    sys.always(open_burst(ended.clone()).implies(burst_state.next()));
    sys.always((&ended & !&master_requests & &other_burst).implies(idle.next()));
    env.always_eventually(!&a1[1]);
    env.always_eventually(&ready);

    // G1: an access starts only if the bus is ready.
    sys.always((!&ready).implies(!start.next()));

    // G2: during a locked burst of unspecified length no access starts.
    let no_burst = !&master_locks | !&start | &burst[0] | &burst[1];
    sys.always((!&g2 & no_burst).implies(!g2.next()));
    let begins = !&g2 & &master_locks & &start & !&burst[0] & !&burst[1];
    sys.always(begins.implies(g2.next()));
    sys.always((&g2 & !&start & &master_requests).implies(g2.next()));
    sys.always((&g2 & &start).implies(Formula::False));
    sys.always((&g2 & !&start & !&master_requests).implies(!g2.next()));
    sys.always_eventually(!&g2);

    // G3: during a locked burst of four accesses no other access starts. The state counts the
    // accesses from 1 to 4. It is 0 outside such a burst.
    let g3_state = |value: usize| number(&g3, value);
    let no_burst = !&master_locks | !&start | (&burst[0] | !&burst[1]);
    let begins = &master_locks & &start & (!&burst[0] & &burst[1]);
    sys.always((g3_state(0) & no_burst).implies(g3_state(0).next()));
    sys.always((g3_state(0) & (&begins & !&ready)).implies(g3_state(1).next()));
    sys.always((g3_state(0) & (&begins & &ready)).implies(g3_state(2).next()));
    for count in 1..=4 {
        let (state, following) = (g3_state(count), g3_state((count + 1) % 5));
        sys.always((&state & (!&start & !&ready)).implies(state.next()));
        sys.always((&state & (!&start & &ready)).implies(following.next()));
        sys.always((&state & &start).implies(Formula::False));
    }
    sys.always_eventually(g3_state(0));

    // G4, G5: when the bus is ready, the granted master gets it, with its lock.
    for (i, grant) in grant.iter().enumerate() {
        sys.always(ready.implies(grant.iff(number(&master, i).next())));
    }
    sys.always(ready.implies((!&locked).iff(!master_locks.next())));

    // G6: until an access starts, master and lock remain.
    for i in 0..masters {
        let is_master = number(&master, i);
        sys.always((!start.next()).implies(is_master.iff(is_master.next())));
    }
    sys.always((!start.next()).implies(master_locks.iff(master_locks.next())));

    // G7: a decision grants the bus to one master, and takes its lock.
    for (lock, grant) in lock.iter().zip(&grant) {
        sys.always((&decide & lock & grant.next()).implies(locked.next()));
        sys.always((&decide & !lock & grant.next()).implies(!locked.next()));
    }

    // G8: without a decision, grants and lock remain.
    for kept in grant.iter().chain([&locked]) {
        sys.always((!&decide).implies((!kept).iff(!kept.next())));
    }

    // G9: a master that requests the bus gets it.
    for (i, request) in request.iter().enumerate() {
        sys.always_eventually(number(&master, i) | !request);
    }

    // G10: nobody is granted the bus without a request, but for the default master 0. The state is
    // set from when a master neither requests nor is granted the bus until its next request.
    for (i, state) in (1..masters).zip(&g10) {
        let (grant, request) = (&grant[i], &request[i]);
        sys.always((!state & (grant | request)).implies(!state.next()));
        sys.always((!state & (!grant & !request)).implies(state.next()));
        sys.always((state & (!grant & !request)).implies(state.next()));
        sys.always((state & (grant & !request)).implies(Formula::False));
        sys.always((state & request).implies(!state.next()));
    }
    let no_request = request
        .iter()
        .fold(decide, |formula, request| formula & !request);
    sys.always(no_request.implies(grant[0].next()));

    print(&format!("amba{masters}"), &env, &sys, format)
}
