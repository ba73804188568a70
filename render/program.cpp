#include "render/program.h"

#include "shaders/shader_source.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace gnomon::render {

namespace {

std::string expand(std::string_view file, int depth = 0) {
    const std::string_view source = shaderSource(file);
    if (source.empty() || depth > 4) {
        spdlog::critical("shader {}: no such file", file);
        std::abort();
    }
    std::string out;
    constexpr std::string_view include = "#include \"";
    for (std::size_t at = 0; at < source.size();) {
        std::size_t end = source.find('\n', at);
        end = end == std::string_view::npos ? source.size() : end + 1;
        const std::string_view line = source.substr(at, end - at);
        // C++ headers in the file that both languages read stand behind __cplusplus with <…>.
        if (line.starts_with(include))
            out += expand(line.substr(include.size(), line.rfind('"') - include.size()), depth + 1);
        else
            out += line;
        at = end;
    }
    return out;
}

std::string defineLines(std::string_view words) {
    std::string lines;
    std::istringstream in{std::string(words)};
    for (std::string word; in >> word;)
        lines += "#define " + word + "\n";
    return lines;
}

// What the driver says goes over many lines; the first tells what is wrong.
[[noreturn]] void stop(const std::string& what, const std::vector<char>& log) {
    std::string line(log.data());
    line = line.substr(0, line.find_first_of("\r\n"));
    std::fprintf(stderr, "error: %s: cannot be used by this OpenGL driver: %s\n", what.c_str(),
                 line.c_str());
    std::fflush(nullptr);
    constexpr int kCannotBeUsed = 65;
    std::_Exit(kCannotBeUsed); // whatever is being written has a temporary name
}

unsigned compile(unsigned stage, std::string_view file, std::string_view defines) {
    std::string source = expand(file);
    // After the first line, which is #version.
    source.insert(source.find('\n') + 1, defineLines(defines));
    const char* text = source.c_str();
    const unsigned shader = glCreateShader(stage);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    int ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        std::vector<char> log(4096);
        glGetShaderInfoLog(shader, int(log.size()), nullptr, log.data());
        stop("shader " + std::string(file), log);
    }
    return shader;
}

} // namespace

Program::Program(std::string_view vertexFile, std::string_view fragmentFile,
                 std::string_view defines)
    : handle_(glCreateProgram()) {
    const unsigned vertex = compile(GL_VERTEX_SHADER, vertexFile, {});
    const unsigned fragment = compile(GL_FRAGMENT_SHADER, fragmentFile, defines);
    glAttachShader(handle_.id(), vertex);
    glAttachShader(handle_.id(), fragment);
    glLinkProgram(handle_.id());
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    int ok = 0;
    glGetProgramiv(handle_.id(), GL_LINK_STATUS, &ok);
    if (!ok) {
        std::vector<char> log(4096);
        glGetProgramInfoLog(handle_.id(), int(log.size()), nullptr, log.data());
        stop("shaders " + std::string(vertexFile) + " and " + std::string(fragmentFile), log);
    }
}

void Program::use() const {
    glUseProgram(handle_.id());
}

} // namespace gnomon::render
