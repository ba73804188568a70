gnomon_test(frame/streaming_gl_test gnomon::frame gnomon::place nlohmann_json::nlohmann_json
  PkgConfig::EPOXY PkgConfig::OPENIMAGEIO)
target_compile_definitions(streaming_gl_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
