# gnomon_library(name SOURCES… ) makes the target gnomon_<name> with alias gnomon::<name>; the links
# between these targets are the architecture (docs/overview.md).
function(gnomon_library name)
  add_library(gnomon_${name} STATIC ${ARGN})
  add_library(gnomon::${name} ALIAS gnomon_${name})
  gnomon_settings(gnomon_${name})
  set_target_properties(gnomon_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  install(TARGETS gnomon_${name} EXPORT gnomon ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  get_property(folders GLOBAL PROPERTY gnomon_installed_folders)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(NOT folder IN_LIST folders)
    set_property(GLOBAL APPEND PROPERTY gnomon_installed_folders ${folder})
    install(DIRECTORY . DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gnomon/${folder} FILES_MATCHING PATTERN "*.h"
      PATTERN place EXCLUDE)
  endif()
  target_compile_features(gnomon_${name} PUBLIC cxx_std_20)
  target_include_directories(gnomon_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/gnomon>)
endfunction()

# -Wno-restrict: GCC 12 sees it falsely in "text" + std::string (its bug 105651).
function(gnomon_settings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> -Wno-sign-conversion -Wno-float-conversion)
  # GLM narrows dvec to vec silently without this; see geo/frames.h.
  target_compile_definitions(${target} PUBLIC GLM_FORCE_EXPLICIT_CTOR)
  # One result on every machine: no fused multiply-add behind our back.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  if(GNOMON_SANITIZE)
    # To look at a vtable the sanitizer makes system calls, which decoders are forbidden in tests.
    target_compile_options(${target} PUBLIC -fsanitize=${GNOMON_SANITIZE} -fno-sanitize=vptr
      -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${GNOMON_SANITIZE})
    # An index out of a vector's size but within what it holds is seen by this alone.
    target_compile_definitions(${target} PUBLIC _GLIBCXX_ASSERTIONS)
  endif()
endfunction()
