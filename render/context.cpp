#include "render/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <iterator>
#include <string_view>
#include <vector>

namespace gnomon::render {

struct Context::Egl {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    ~Egl() {
        if (display == EGL_NO_DISPLAY)
            return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT)
            eglDestroyContext(display, context);
        eglTerminate(display);
    }
};

namespace {

void GLAPIENTRY onDebugMessage(GLenum, GLenum type, GLuint, GLenum severity, GLsizei,
                               const GLchar* message, const void* fatal) {
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION)
        return;
    const bool wrong = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
    if (!wrong) {
        spdlog::debug("GL: {}", message);
        return;
    }
    spdlog::error("GL: {}", message);
    if (fatal != nullptr)
        std::abort();
}

bool has(const char* extensions, std::string_view name) {
    return extensions != nullptr &&
           std::string_view(extensions).find(name) != std::string_view::npos;
}

bool isSoftwareName(std::string_view renderer) {
    return renderer.find("llvmpipe") != std::string_view::npos ||
           renderer.find("softpipe") != std::string_view::npos ||
           renderer.find("SWR") != std::string_view::npos;
}

std::vector<EGLDeviceEXT> eglDevices(const char* clientExtensions) {
    if (!has(clientExtensions, "EGL_EXT_device_enumeration") &&
        !has(clientExtensions, "EGL_EXT_device_base"))
        return {};
    EGLint count = 0;
    if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0)
        return {};
    std::vector<EGLDeviceEXT> devices(std::size_t(count), EGLDeviceEXT{});
    eglQueryDevicesEXT(count, devices.data(), &count);
    devices.resize(std::size_t(count));
    return devices;
}

bool isSoftwareDevice(EGLDeviceEXT device) {
    return has(eglQueryDeviceStringEXT(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
}

// A display to try, and how to name it in a message.
struct Candidate {
    EGLDisplay display = EGL_NO_DISPLAY;
    std::string name;
};

std::vector<Candidate> candidates(const ContextOptions& options) {
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Candidate> list;
    const std::vector<EGLDeviceEXT> devices = eglDevices(client);
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const bool software = isSoftwareDevice(devices[i]);
        const bool wanted = options.device
                                ? (*options.device == int(i) || (*options.device == -1 && software))
                                : !software;
        if (wanted)
            list.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr),
                            "EGL device " + std::to_string(i)});
    }
    if (!options.device || *options.device == -1) {
        if (has(client, "EGL_MESA_platform_surfaceless"))
            list.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                     EGL_DEFAULT_DISPLAY, nullptr),
                            "Mesa surfaceless"});
        for (std::size_t i = 0; i < devices.size(); ++i)
            if (isSoftwareDevice(devices[i]))
                list.push_back(
                    {eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr),
                     "EGL software device"});
    }
    return list;
}

// Empty when the display gives a GL 4.5 core context; else why not.
std::string makeCurrent(EGLDisplay display, EGLContext& context) {
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr))
        return "cannot be initialised";
    if (!eglBindAPI(EGL_OPENGL_API))
        return "has no OpenGL";
    const EGLint configAttributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                       EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!eglChooseConfig(display, configAttributes, &config, 1, &count) || count == 0)
        return "has no OpenGL configuration";
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 EGL_TRUE,
                                 EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                 EGL_LOSE_CONTEXT_ON_RESET,
                                 EGL_NONE};
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT) { // a driver that cannot tell of resets; see Context::lost()
        std::vector<EGLint> without(std::begin(attributes), std::end(attributes) - 3);
        without.push_back(EGL_NONE);
        context = eglCreateContext(display, config, EGL_NO_CONTEXT, without.data());
    }
    if (context == EGL_NO_CONTEXT)
        return "has no OpenGL 4.5 core context";
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        return "cannot be used without a surface";
    return {};
}

} // namespace

Context::Context(std::unique_ptr<Egl> egl) : egl_(std::move(egl)) {}
Context::~Context() = default;

Result<std::unique_ptr<Context>> Context::createHeadless(const ContextOptions& options) {
    std::string tried;
    for (const Candidate& candidate : candidates(options)) {
        auto egl = std::make_unique<Egl>();
        egl->display = candidate.display;
        const std::string why = makeCurrent(egl->display, egl->context);
        if (!why.empty()) {
            tried += (tried.empty() ? "" : "; ") + candidate.name + " " + why;
            continue;
        }
        std::unique_ptr<Context> context(new Context(std::move(egl)));
        if (Failure failure = context->checkAndSetUp(options)) {
            tried += (tried.empty() ? "" : "; ") + candidate.name + " " + failure->reason;
            continue;
        }
        return context;
    }
    return Error{"OpenGL", tried.empty() ? "no EGL display here; is Mesa installed?" : tried,
                 ErrorKind::Input};
}

Result<std::unique_ptr<Context>> Context::adoptCurrent(const ContextOptions& options) {
    std::unique_ptr<Context> context(new Context(nullptr));
    if (Failure failure = context->checkAndSetUp(options))
        return *failure;
    return context;
}

Failure Context::checkAndSetUp(const ContextOptions& options) {
    if (epoxy_gl_version() < 45)
        return Error{"OpenGL", "is older than 4.5"};
    if (!epoxy_has_gl_extension("GL_ARB_clip_control"))
        return Error{"OpenGL", "lacks clip control (GL_ARB_clip_control), without which far things "
                               "cannot be told apart"};
    renderer_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(onDebugMessage, options.debugIsFatal ? this : nullptr);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    return {};
}

bool Context::isSoftware() const {
    return isSoftwareName(renderer_);
}

void Context::finish() const {
    glFinish();
}

bool Context::lost() const {
    return glGetGraphicsResetStatus() != GL_NO_ERROR;
}

bool Context::outOfMemory() const {
    bool out = false;
    constexpr int kMostFlags = 16; // a lost context may report without end
    for (int i = 0; i < kMostFlags; ++i) {
        const GLenum error = glGetError();
        out = out || error == GL_OUT_OF_MEMORY;
        if (error == GL_NO_ERROR)
            break;
    }
    return out;
}

} // namespace gnomon::render
