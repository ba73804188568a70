foreach(name scenes)
  gnomon_test(bench/${name}_test gnomon::bench gnomon::streaming)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
