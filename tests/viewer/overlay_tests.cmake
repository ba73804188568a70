foreach(name overlay_marks_test font_test overlay_test overlay_facts_test)
  gnomon_test(viewer/${name} gnomon::command)
  target_compile_definitions(${name} PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
