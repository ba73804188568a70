// What stands where. The plan is a function of (seed, number of buildings): a square of cells of
// 128 m, each of which can be laid out alone, in any order. Streets run along the cells' edges, so
// nothing that stands crosses one, and a cell is a leaf tile of the quadtree.
#pragma once

#include "viewer/place/random.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace gnomon::builtin {

inline constexpr double kCellMetres = 128.0;
// Every vertex lies on this lattice (of the whole place, not of a tile): tiles meet exactly, Draco
// loses nothing, and floats hold it exactly to 65 km.
inline constexpr double kLatticeMetres = 1.0 / 256.0;
double onLattice(double metres);
// The finest terrain grid, and every tile's edge.
inline constexpr double kGroundStepMetres = 4.0;

struct Rect {
    double west = 0, south = 0, east = 0, north = 0;

    double width() const { return east - west; }
    double height() const { return north - south; }
    glm::dvec2 centre() const { return {(west + east) / 2, (south + north) / 2}; }
    bool contains(glm::dvec2 p) const {
        return p.x >= west && p.x < east && p.y >= south && p.y < north;
    }
    Rect inset(double d) const { return {west + d, south + d, east - d, north - d}; }
};

enum class Roof { Flat, Gable, Hip, Shed };
enum class Facade { Houses, Offices };

struct Building {
    glm::dvec2 centre{0};
    double headingRadians = 0; // of its own x axis, counter-clockwise from east
    glm::dvec2 half{0};        // half sizes along its own axes
    glm::dvec2 notch{0}; // > 0: an L, this much cut from the +x +y corner; for other corners…
    glm::ivec2 notchCorner{1}; // …±1, ±1
    double baseMetres = 0;     // below the lowest ground around it
    double groundMetres = 0;   // the highest ground around it
    double eavesMetres = 0;
    double roofMetres = 0; // ridge above the eaves
    Roof roof = Roof::Flat;
    bool ridgeAlongX = true;
    double overhangMetres = 0, gableOverhangMetres = 0;
    Facade facade = Facade::Houses;
    bool chimney = false, roofBox = false;
    glm::vec3 wallColor{1}, roofColor{1}; // sRGB
    double storeyMetres = 3.1;

    // The footprint's corners, counter-clockwise; four, or six for an L. `grow` moves edges out.
    std::vector<glm::dvec2> footprint(double grow = 0) const;
    double topMetres() const { return eavesMetres + roofMetres; }
};

enum class TreeKind { Broad, Poplar, Conifer };
struct Tree {
    glm::dvec2 at{0};
    double heightMetres = 8;
    double headingRadians = 0;
    TreeKind kind = TreeKind::Broad;
};

// A bus shelter or garden shed of single, one-sided walls: open, front to the heading.
struct Shed {
    glm::dvec2 at{0};
    double headingRadians = 0;
    glm::dvec3 size{3, 1.5, 2.4};
};

enum class CellKind { Country, Blocks, Park, Square, Bridge };

struct Block {
    Rect rect;
    bool green = true; // lawns rather than paving
};

struct Cell {
    CellKind kind = CellKind::Country;
    Rect rect;
    std::vector<Block> blocks;          // what is in no block is street
    std::vector<glm::dvec2> innerLines; // x, NaN or NaN, y: centres of streets inside
    std::vector<Building> buildings;
    std::vector<Tree> trees;
    std::vector<Shed> sheds;
};

enum class Side { West, East, South, North };

struct HeightRange {
    double low = 0, high = 0;
};

class Plan {
  public:
    Plan(std::uint64_t seed, std::size_t buildings);

    int levels() const { return levels_; } // 2^levels cells across
    int cells() const { return 1 << levels_; }
    int firstCell() const { return -(cells() / 2); } // cell indices are first … first + cells - 1
    double sideMetres() const { return cells() * kCellMetres; }
    double radiusMetres() const { return radius_; } // of the built-up part, about the centre
    static constexpr glm::dvec2 centre() { return {64.0, 64.0}; }
    std::uint64_t seed() const { return seed_; }

    CellKind kind(int ix, int iy) const;
    // True where finer tiles are worth having: built-up cells and those next to them.
    bool detailed(int ix, int iy) const;
    Cell cell(int ix, int iy) const;

    // Ground: the formula, and the triangulated grid of `stepMetres` that is drawn.
    double terrain(glm::dvec2 p) const;
    double gridHeight(std::int64_t i, std::int64_t j) const; // at i, j steps of the finest grid
    double ground(glm::dvec2 p, double stepMetres = kGroundStepMetres) const;

    // Distance to the river's middle line, and half its width.
    double riverDistance(glm::dvec2 p) const;
    double riverHalfWidth() const { return riverHalf_; }
    // Signed distance to the diagonal avenue's middle; huge where it does not run.
    double avenueDistance(glm::dvec2 p) const;
    // Half a street's width, sidewalks included, along the line x (or y) = index cells.
    double streetHalf(bool vertical, int line) const;

    // The bridge: along y at this x, from deckSouth to deckNorth, its top at deckMetres.
    static constexpr double axisX() { return 64.0; }
    double bridgeY() const { return bridgeY_; }
    double deckHalfLength() const { return riverHalf_ + 30.0; }
    double deckMetres() const { return deck_; }
    // All that stands or lies in the place.
    HeightRange heightRange() const;
    double towerMetres() const { return 120.0; } // above its ground

  private:
    friend struct CellLayout;
    static constexpr std::uint16_t kCountryCell = 0xffff, kAllBuildings = 0xfffe;
    std::size_t indexOf(int ix, int iy) const;
    // The cells of the straight street from the tower to beyond the bridge.
    bool onAxis(int ix, int iy) const { return ix == 0 && iy <= 0 && iy >= bridgeCell_ - 1; }
    double marginAt(Side side, int ix, int iy) const;

    std::uint64_t seed_;
    double radius_ = 0, riverHalf_ = 0, riverSwing_ = 0, riverLength_ = 0, bridgeY_ = 0, deck_ = 0;
    double hills_ = 0;
    int levels_ = 0;
    int bridgeCell_ = 0;
    std::vector<std::uint16_t> quota_; // buildings a cell may have; or one of the two above
};

} // namespace gnomon::builtin
