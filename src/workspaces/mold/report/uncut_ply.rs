//! The surface of a mold that cutters leave uncut, as a file for other programs.

use mold::opening::Opening;
use mold::surface::SurfacePiece;

/// The pieces of the surface as PLY, in the axes of the mesh: every corner with the height of what is left above it
/// (`depth`, mm), every triangle with its region, counted from 1, and the triangle of the mesh that it is of, counted from
/// 0.
pub fn surface_as_ply(pieces: &[SurfacePiece], opening: Opening) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment sparkpath: what cutters leave uncut, mm\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nproperty float depth\n\
         element face {}\nproperty list uchar int vertex_indices\nproperty int region\nproperty int face\nend_header\n",
        3 * pieces.len(),
        pieces.len()
    )
    .into_bytes();
    for piece in pieces {
        for (p, depth) in piece.corners.iter().zip(piece.depth) {
            let [x, y, z] = opening.in_mesh(*p).as_vec3().to_array();
            [x, y, z, depth].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
    }
    for (i, piece) in pieces.iter().enumerate() {
        let first = 3 * i as i32;
        bytes.push(3);
        let numbers = [first, first + 1, first + 2, piece.region as i32 + 1, piece.face as i32];
        numbers.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn every_piece_has_its_corners_its_region_and_its_face() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let pieces = [SurfacePiece { corners, face: 7, region: 2, depth: [0.5, 1.0, 1.5] }];
        let bytes = surface_as_ply(&pieces, Opening::PlusX);
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.contains("element vertex 3\n") && header.contains("element face 1\n"), "{header}");
        let body = &bytes[end..];
        assert_eq!(body.len(), 3 * 16 + 1 + 5 * 4);
        let vertex: Vec<f32> = body[..16].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        let in_mesh = Opening::PlusX.in_mesh(DVec3::X).as_vec3();
        assert_eq!(vertex, [in_mesh.x, in_mesh.y, in_mesh.z, 0.5]);
        let numbers: Vec<i32> = body[49..].chunks(4).map(|b| i32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!((body[48], numbers), (3, vec![0, 1, 2, 3, 7]));
    }
}
