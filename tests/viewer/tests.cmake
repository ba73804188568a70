set(viewer_tests options_test camera_path_test kml_tour_test scene_file_test scene_test input_test output_name_test
  image_file_test output_file_test video_file_test progress_test shot_test command_line_test
  capture_gl_test lamps_file_test terrain_scene_test)
foreach(name ${viewer_tests})
  gnomon_test(viewer/${name} gnomon::command PkgConfig::OPENIMAGEIO nlohmann_json::nlohmann_json)
  target_compile_definitions(${name} PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
foreach(name command_line_test capture_gl_test)
  target_compile_definitions(${name} PRIVATE GNOMON_PROGRAM="$<TARGET_FILE:gnomon>")
  add_dependencies(${name} gnomon)
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/overlay_tests.cmake OPTIONAL)
