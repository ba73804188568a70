gnomon_test(frame/water_gl_test gnomon::frame)
target_compile_definitions(water_gl_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
