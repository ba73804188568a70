foreach(name frame shadow_shape shadow_plane penumbra stability real_data golden rigidity plane_optimal lamp bias dual_layers filter)
  gnomon_test(frame/${name}_gl_test gnomon::frame PkgConfig::OPENIMAGEIO
    nlohmann_json::nlohmann_json PkgConfig::EPOXY)
  target_compile_definitions(${name}_gl_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/water_tests.cmake OPTIONAL)
include(${CMAKE_CURRENT_LIST_DIR}/streaming_tests.cmake OPTIONAL)
