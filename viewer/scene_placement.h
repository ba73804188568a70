// Where an input stands: on the Earth by its own account, or where the user puts it.
#pragma once

#include "viewer/scene.h"

#include <chrono>
#include <optional>
#include <vector>

namespace gnomon {

// Near the Earth's surface, or around the whole Earth. Not what lies in a map projection's
// coordinates that happen to be as far from their origin as the surface is from the Earth's centre.
bool standsOnEarth(const BoundingVolume& volume);

// Which axis of a frame is up. A glTF file's own z, if that is up, is -y once the file is decoded,
// since 3D Tiles turns glTF's y to z.
enum class FrameUp { Y, Z, MinusY };

// Origin, heading and up axis to ECEF. Before the heading turns them, x is east, and north is y (z
// up), -z (y up) or z (-y up).
Transform<Ecef, Tile> placedFrame(const Placement& placement, double raiseMetres, FrameUp up);

// The origin of a frame that stands upright on the Earth, z along the ellipsoid's normal. At a pole
// the frame's own x says which longitude's east it is. Nullopt for any other frame.
std::optional<Geodetic> uprightOrigin(const Transform<Ecef, Tile>& frame);

// The first contents of a tileset, breadth first, loaded one after the other. Failed ones are
// passed over. The same set for the same tileset, however fast the disk is. With a deadline, what
// fails in passing until then (a server that is away) is an error.
using FirstContents = std::vector<std::shared_ptr<const TileContent>>;
Result<FirstContents>
firstContents(StreamedTileset& tileset, std::size_t count,
              std::optional<std::chrono::steady_clock::time_point> deadline = {});

// The axis an open surface faces: Y when terrain-like geometry in its own frame says so. Nullopt
// when the geometry tells nothing (closed bodies, walls).
std::optional<ModelUp> upFromGeometry(const FirstContents& some);

} // namespace gnomon
