foreach(name shadow_shape_gl shadow_plane_gl)
  gnomon_test(frame/${name}_test gnomon::frame PkgConfig::OPENIMAGEIO nlohmann_json::nlohmann_json
    PkgConfig::EPOXY)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
