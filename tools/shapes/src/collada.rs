//! COLLADA, with one geometry, shown once.

use crate::mesh::Mesh;

/// A file of vertices and polygons. Each corner has the index of a normal, which readers must skip,
/// before the index of its vertex. The frame is turned and scaled, and turned back by the node.
pub fn file(mesh: &Mesh) -> String {
    let positions: Vec<String> = mesh.vertices.iter().map(|[x, y, z]| format!("{y} {z} {x}")).collect();
    let counts: Vec<String> = mesh.faces.iter().map(|face| face.len().to_string()).collect();
    let corners: Vec<String> = mesh.faces.iter().flatten().map(|corner| format!("0 {corner}")).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
         <COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n\
         <asset><unit name=\"meter\" meter=\"1\"/><up_axis>Z_UP</up_axis></asset>\n\
         <library_geometries><geometry id=\"mesh\"><mesh>\n\
         <source id=\"positions\"><float_array id=\"array\" count=\"{}\">{}</float_array><technique_common>\n\
         <accessor source=\"#array\" count=\"{}\" stride=\"3\"><param name=\"X\"/><param name=\"Y\"/><param name=\"Z\"/>\n\
         </accessor></technique_common></source>\n\
         <vertices id=\"vertices\"><input semantic=\"POSITION\" source=\"#positions\"/></vertices>\n\
         <polylist count=\"{}\"><input semantic=\"NORMAL\" source=\"#normals\" offset=\"0\"/>\n\
         <input semantic=\"VERTEX\" source=\"#vertices\" offset=\"1\"/>\n<vcount>{}</vcount>\n<p>{}</p></polylist>\n\
         </mesh></geometry></library_geometries>\n\
         <library_visual_scenes><visual_scene id=\"scene\"><node id=\"node\">\n\
         <matrix>0 0 1 0  1 0 0 0  0 1 0 0  0 0 0 1</matrix>\n\
         <instance_geometry url=\"#mesh\"/></node></visual_scene></library_visual_scenes>\n\
         <scene><instance_visual_scene url=\"#scene\"/></scene>\n</COLLADA>\n",
        3 * mesh.vertices.len(),
        positions.join(" "),
        mesh.vertices.len(),
        mesh.faces.len(),
        counts.join(" "),
        corners.join(" ")
    )
}
