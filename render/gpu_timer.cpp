#include "render/gpu_timer.h"

#include <epoxy/gl.h>

namespace gnomon::render {

void GpuTimer::start() {
    used_ = 0;
    set();
}

void GpuTimer::mark() {
    set();
}

void GpuTimer::set() {
    if (used_ == queries_.size()) {
        unsigned id = 0;
        glCreateQueries(GL_TIMESTAMP, 1, &id);
        queries_.emplace_back(id);
        // llvmpipe's first result is garbage: spend one.
        glQueryCounter(id, GL_TIMESTAMP);
        GLuint64 spent = 0;
        glGetQueryObjectui64v(id, GL_QUERY_RESULT, &spent);
    }
    glQueryCounter(queries_[used_++].id(), GL_TIMESTAMP);
}

std::vector<double> GpuTimer::milliseconds() {
    std::vector<double> out;
    GLuint64 last = 0;
    for (std::size_t i = 0; i < used_; ++i) {
        GLuint64 now = 0;
        glGetQueryObjectui64v(queries_[i].id(), GL_QUERY_RESULT, &now);
        if (i > 0)
            out.push_back(double(now - last) * 1e-6);
        last = now;
    }
    return out;
}

} // namespace gnomon::render
