// Frames are types, so that a position of one frame cannot be taken for one of another.
//
// The world is ECEF (WGS 84, metres, double). Float appears in one place only: relativeTo(), which
// subtracts a near origin first. Transforms are named destination first: `enuFromEcef`.
#pragma once

#ifndef GLM_FORCE_EXPLICIT_CTOR
#error "compile with GLM_FORCE_EXPLICIT_CTOR: without it GLM narrows double to float silently"
#endif
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace gnomon {

struct Ecef;  // Earth-centred, Earth-fixed: x to (0°N, 0°E), z to the north pole
struct Enu;   // east, north, up at the scene's anchor
struct Tile;  // the frame a tile's content is written in, before its transform
struct Eye;   // right, up, backward (OpenGL habit), origin at the camera
struct Light; // right, up, towards the sun; origin at the scene's anchor

template <class Frame>
struct Vector {
    glm::dvec3 xyz{0.0};
};

template <class Frame>
struct Point {
    glm::dvec3 xyz{0.0};
};

template <class F>
Vector<F> operator-(Point<F> a, Point<F> b) {
    return {a.xyz - b.xyz};
}
template <class F>
Point<F> operator+(Point<F> a, Vector<F> b) {
    return {a.xyz + b.xyz};
}
template <class F>
Point<F> operator-(Point<F> a, Vector<F> b) {
    return {a.xyz - b.xyz};
}
template <class F>
Vector<F> operator+(Vector<F> a, Vector<F> b) {
    return {a.xyz + b.xyz};
}
template <class F>
Vector<F> operator-(Vector<F> a, Vector<F> b) {
    return {a.xyz - b.xyz};
}
template <class F>
Vector<F> operator-(Vector<F> a) {
    return {-a.xyz};
}
template <class F>
Vector<F> operator*(double s, Vector<F> a) {
    return {s * a.xyz};
}
template <class F>
Vector<F> operator*(Vector<F> a, double s) {
    return {s * a.xyz};
}
template <class F>
double dot(Vector<F> a, Vector<F> b) {
    return glm::dot(a.xyz, b.xyz);
}
template <class F>
Vector<F> cross(Vector<F> a, Vector<F> b) {
    return {glm::cross(a.xyz, b.xyz)};
}
template <class F>
double length(Vector<F> a) {
    return glm::length(a.xyz);
}
template <class F>
Vector<F> normalize(Vector<F> a) {
    return {glm::normalize(a.xyz)};
}

// An affine map between frames. Columns are the images of the source axes, the last the image of
// the source origin (glm's own layout, and that of 3D Tiles).
template <class To, class From>
struct Transform {
    glm::dmat4 matrix{1.0};

    Point<To> operator()(Point<From> p) const {
        return {glm::dvec3(matrix * glm::dvec4(p.xyz, 1.0))};
    }
    Vector<To> operator()(Vector<From> v) const { return {glm::dmat3(matrix) * v.xyz}; }
    Point<To> origin() const { return {glm::dvec3(matrix[3])}; }
    // Columns: the source axes seen in the destination frame.
    glm::dmat3 axes() const { return glm::dmat3(matrix); }
};

template <class A, class B, class C>
Transform<A, C> operator*(const Transform<A, B>& aFromB, const Transform<B, C>& bFromC) {
    return {aFromB.matrix * bFromC.matrix};
}

// Inverse of a rotation and a shift (exact to rounding; no general matrix inverse).
template <class To, class From>
Transform<From, To> rigidInverse(const Transform<To, From>& t) {
    const glm::dmat3 r = glm::transpose(t.axes());
    glm::dmat4 m(r);
    m[3] = glm::dvec4(-(r * t.origin().xyz), 1.0);
    return {m};
}

// The one place where double becomes float.
template <class F>
glm::vec3 relativeTo(Point<F> origin, Point<F> p) {
    return glm::vec3(p.xyz - origin.xyz);
}

} // namespace gnomon
