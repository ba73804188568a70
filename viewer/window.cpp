#include "viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace gnomon {

struct Window::State {
    GLFWwindow* window = nullptr;
    Input input;
    double cursorX = 0, cursorY = 0;

    ~State() {
        if (window != nullptr)
            glfwDestroyWindow(window);
        glfwTerminate();
    }
    static State& of(GLFWwindow* w) { return *static_cast<State*>(glfwGetWindowUserPointer(w)); }
    void moved(double x, double y);
    void watch();
};

void Window::State::moved(double x, double y) {
    const double dx = x - cursorX, dy = y - cursorY;
    cursorX = x;
    cursorY = y;
    const bool left = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
    const bool right = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
    const bool ctrl = glfwGetKey(window, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                      glfwGetKey(window, GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
    if (right || (left && ctrl)) {
        input.turnX += dx;
        input.turnY += dy;
    } else if (left) {
        input.panX += dx;
        input.panY += dy;
    }
}

void Window::State::watch() {
    glfwSetWindowUserPointer(window, this);
    glfwGetCursorPos(window, &cursorX, &cursorY);
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) { of(w).moved(x, y); });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) { of(w).input.wheel += y; });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
        if (action == GLFW_PRESS && (key == GLFW_KEY_ESCAPE || key == GLFW_KEY_Q))
            of(w).input.quit = true;
    });
    glfwSetWindowCloseCallback(window, [](GLFWwindow* w) { of(w).input.quit = true; });
    glfwSetFramebufferSizeCallback(window,
                                   [](GLFWwindow* w, int, int) { of(w).input.resized = true; });
}

Window::Window(std::unique_ptr<State> state) : state_(std::move(state)) {}
Window::~Window() = default;

Result<std::unique_ptr<Window>> Window::open(const std::string& title, int width, int height) {
    glfwSetErrorCallback(nullptr);
    const Error none{"window", "cannot be opened here (no display, or no OpenGL 4.5 on it); "
                               "`gnomon capture` draws pictures and videos without one"};
    if (!glfwInit())
        return none;
    auto state = std::make_unique<State>();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, GLFW_TRUE);
    state->window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (state->window == nullptr)
        return none;
    glfwMakeContextCurrent(state->window);
    glfwSwapInterval(1);
    state->watch();
    return std::unique_ptr<Window>(new Window(std::move(state)));
}

Window::Input Window::poll(double secondsAtMost) {
    state_->input = {};
    if (secondsAtMost > 0.0)
        glfwWaitEventsTimeout(secondsAtMost);
    else
        glfwPollEvents();
    return state_->input;
}

int Window::width() const {
    int w = 0, h = 0;
    glfwGetFramebufferSize(state_->window, &w, &h);
    return w;
}

int Window::height() const {
    int w = 0, h = 0;
    glfwGetFramebufferSize(state_->window, &w, &h);
    return h;
}

void Window::swap() {
    glfwSwapBuffers(state_->window);
}

} // namespace gnomon
