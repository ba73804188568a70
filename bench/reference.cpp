#include "bench/reference.h"

#include "bench/parallel.h"
#include "bench/reference_disc.h"
#include "bench/reference_state.h"
#include "render/visibility_pass.h"

#include <algorithm>
#include <chrono>
#include <new>

namespace gnomon::bench {

namespace {

// The camera along the stored axes.
struct Pinhole {
    glm::dvec3 position, right, up, forward; // right and up: half the picture at distance 1
    int width, height;

    Pinhole(const RayScene& scene, const Camera& camera)
        : position(scene.stored(camera.position)),
          right(scene.stored(camera.right) * camera.tanHalfWidth()),
          up(scene.stored(camera.up) * camera.tanHalfHeight()),
          forward(scene.stored(camera.forward)), width(camera.widthPixels),
          height(camera.heightPixels) {}

    // Through the pixel's centre; its component along `forward` is 1.
    glm::dvec3 ray(int x, int y) const {
        const double u = (2.0 * x + 1.0) / width - 1.0, v = 1.0 - (2.0 * y + 1.0) / height;
        return forward + u * right + v * up;
    }
};

} // namespace

// Fills its rows of the reference.
struct Tracer {
    const RayScene& scene;
    const Pinhole camera;
    const ReferenceOptions& options;
    const DiscTable table;
    Reference& out;

    Tracer(const RayScene& rays, const Camera& from, const ReferenceOptions& how, Reference& into)
        : scene(rays), camera(rays, from), options(how), table(how.raysPerPixel), out(into) {}

    void pixel(int x, int y) const {
        const std::size_t i = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
        const RayScene::State& rays = *scene.state_;
        SurfacePoint& p = out.surfaces[i] = seen(*rays.rays, x, y);
        if (!p.any)
            return;
        const Incoming incoming = incomingAt(p.position, options.light);
        out.hard[i] = out.visibility[i] = float(rays.centre(p.position, p.normal, incoming));
        if (options.raysPerPixel > 1 && incoming.tangent > 0.0)
            out.visibility[i] =
                float(rays.disc(p.position, p.normal, incoming, table.points(std::uint32_t(i))));
    }
    SurfacePoint seen(const Rays& rays, int x, int y) const {
        Ray ray;
        ray.from = camera.position;
        ray.direction = camera.ray(x, y);
        ray.minimum = render::kNearPlaneMetres; // nothing nearer is drawn
        const RayHit hit = rays.nearest(ray);
        if (!hit.any)
            return {};
        return {true, hit.position, hit.normal,
                glm::dot(hit.position - camera.position, camera.forward), hit.mesh};
    }
    void rows(std::size_t begin, std::size_t end) const {
        for (std::size_t y = begin; y < end; ++y)
            for (int x = 0; x < camera.width; ++x)
                pixel(x, int(y));
    }
};

Result<Reference> traceReference(const RayScene& scene, const Camera& camera,
                                 const ReferenceOptions& options,
                                 const std::function<bool(int done, int all)>& progress) {
    const auto start = std::chrono::steady_clock::now();
    Reference out;
    out.width = std::max(camera.widthPixels, 1);
    out.height = std::max(camera.heightPixels, 1);
    out.raysPerPixel = std::max(options.raysPerPixel, 1);
    const std::size_t pixels = std::size_t(out.width) * std::size_t(out.height);
    try {
        out.surfaces.resize(pixels);
        out.visibility.assign(pixels, 1.0f);
        out.hard.assign(pixels, 1.0f);
    } catch (const std::bad_alloc&) {
        return Error{"reference", "not enough memory for the picture", ErrorKind::Transient};
    }
    const Tracer tracer(scene, camera, options, out);
    const auto goOn = [&](std::size_t done) { return progress(int(done), out.height); };
    const bool finished = inParallelWhile(
        std::size_t(out.height), 1, options.threads,
        [&](std::size_t begin, std::size_t end) { tracer.rows(begin, end); },
        progress ? goOn : std::function<bool(std::size_t)>());
    if (!finished)
        return Error{"reference", "stopped", ErrorKind::Transient};
    out.milliseconds =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return out;
}

} // namespace gnomon::bench
