// Compaction by prefix sums: a list of the pairs whose status is in a range, in the order of the
// list before. So the place of a pair does not depend on which thread is first.
//
// 1. `count_kept`: how many pairs each workgroup keeps.
// 2. `sum_counts`: where each workgroup's pairs start, and their number. One workgroup.
// 3. `write_kept`: the pairs.

@group(0) @binding(4) var<storage, read> answers: array<Answer>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read_write> kept: array<u32>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

const GROUP = 256u;

var<workgroup> sums: array<u32, GROUP>;

// Sum of the values of all threads of the workgroup up to this one.
fn sum_up_to(local_thread: u32, value: u32) -> u32 {
    sums[local_thread] = value;
    workgroupBarrier();
    for (var distance = 1u; distance < GROUP; distance <<= 1u) {
        var before = 0u;
        if local_thread >= distance {
            before = sums[local_thread - distance];
        }
        workgroupBarrier();
        sums[local_thread] += before;
        workgroupBarrier();
    }
    return sums[local_thread];
}

// 1 if the pair at this place of the list is kept.
fn keep(at: u32) -> u32 {
    if at >= list[0] {
        return 0u;
    }
    let status = answers[list[at + 1u]].status;
    return select(0u, 1u, status >= parameters.keep_from && status <= parameters.keep_to);
}

@compute @workgroup_size(GROUP)
fn count_kept(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local_thread: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    let sum = sum_up_to(local_thread, keep(id.x));
    if local_thread == GROUP - 1u {
        counts[group.x] = sum;
    }
}

@compute @workgroup_size(GROUP)
fn sum_counts(@builtin(local_invocation_index) local_thread: u32) {
    let groups = (parameters.count + GROUP - 1u) / GROUP;
    var base = 0u;
    for (var first = 0u; first < groups; first += GROUP) {
        let at = first + local_thread;
        var count = 0u;
        if at < groups {
            count = counts[at];
        }
        let sum = sum_up_to(local_thread, count);
        if at < groups {
            counts[at] = base + sum - count;
        }
        base += sums[GROUP - 1u];
        workgroupBarrier();
    }
    if local_thread == 0u {
        kept[0] = base;
    }
}

@compute @workgroup_size(GROUP)
fn write_kept(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local_thread: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    let is_kept = keep(id.x);
    let sum = sum_up_to(local_thread, is_kept);
    if is_kept == 1u {
        kept[counts[group.x] + sum] = list[id.x + 1u];
    }
}
