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

@compute @workgroup_size(64)
fn find_vertices(@builtin(global_invocation_id) id: vec3u) {
    if id.x < parameters.count {
        fuel = MAX_READS;
        let query = directions[id.x];
        var found = Found(vec3f(), NO_INDEX, false);
        if query.hull != NO_INDEX {
            found = support_of(query.hull, query.dir);
        }
        var vertex = 0u;
        if found.at != NO_INDEX {
            vertex = blocks[found.at + 24u];
        }
        vertices[id.x] = FoundRecord(found.offset, vertex, u32(found.is_certain), 0u, 0u, 0u);
    }
}
