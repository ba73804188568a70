// A linked GLSL program made from the files of shaders/. `#include "x"` is replaced by that file.
// A shader that does not compile is our own mistake or the driver's: it is named in one line, and
// the program ends as without a usable OpenGL (exit code 65).
#pragma once

#include "render/handles.h"

#include <string_view>

namespace gnomon::render {

class Program {
  public:
    Program() = default;
    // Each word of `defines`, between blanks, is put into the fragment shader as `#define word`.
    Program(std::string_view vertexFile, std::string_view fragmentFile,
            std::string_view defines = {});
    void use() const;
    unsigned id() const { return handle_.id(); }

  private:
    Handle<detail::destroyProgram> handle_;
};

} // namespace gnomon::render
