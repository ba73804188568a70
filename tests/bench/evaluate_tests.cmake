foreach(name metrics contours techniques plot report)
  gnomon_test(bench/${name}_test gnomon::bench nlohmann_json::nlohmann_json)
endforeach()
gnomon_test(bench/evaluate_gl_test gnomon::bench PkgConfig::OPENIMAGEIO)
gnomon_test(bench/evaluate_command_gl_test gnomon::command nlohmann_json::nlohmann_json)
target_compile_definitions(evaluate_gl_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_compile_definitions(evaluate_command_gl_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
  GNOMON_PROGRAM="$<TARGET_FILE:gnomon>")
add_dependencies(evaluate_command_gl_test gnomon)
