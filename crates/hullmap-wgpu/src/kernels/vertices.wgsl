// The support kernel: one direction for each thread.

struct Direction {
    dir: vec3f,
    hull: u32,
}

struct FoundRecord {
    offset: vec3f,
    vertex: u32,
    is_certain: u32,
    padding_x: u32,
    padding_y: u32,
    padding_z: u32,
}

@group(0) @binding(4) var<storage, read> directions: array<Direction>;
@group(0) @binding(5) var<storage, read_write> vertices: array<FoundRecord>;

@compute @workgroup_size(WORKGROUP)
fn find_vertices(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    local_thread = local;
    if id.x < parameters.count {
        fuel = MAX_READS;
        let query = directions[id.x];
        var found = Found(vec3f(), NO_INDEX, false);
        if query.hull != NO_INDEX {
            found = support_of(query.hull, query.dir);
        }
        var vertex = 0u;
        if found.at != NO_INDEX {
            vertex = blocks[found.at / BLOCK_WORDS].vertex[(found.at >> 2u) & 1u][found.at & 3u];
        }
        let is_certain = found.is_certain && !loops_end_early();
        vertices[id.x] = FoundRecord(found.offset, vertex, u32(is_certain), 0u, 0u, 0u);
    }
}
