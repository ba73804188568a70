# A web server that fails on purpose, for the tests here and elsewhere; and as a program.
add_library(gnomon_fault_server STATIC faults/fault_server.cpp faults/answer.cpp
  faults/connection.cpp faults/served_file.cpp faults/http_text.cpp)
gnomon_settings(gnomon_fault_server)
target_include_directories(gnomon_fault_server PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(gnomon_fault_server PUBLIC Threads::Threads PRIVATE ZLIB::ZLIB)
add_executable(fault_server faults/fault_server_main.cpp)
gnomon_settings(fault_server)
target_link_libraries(fault_server PRIVATE gnomon_fault_server CLI11::CLI11)
set_target_properties(fault_server PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})

gnomon_test(faults/fault_server_test gnomon_fault_server ZLIB::ZLIB)
target_compile_definitions(fault_server_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# gnomon itself over such a server, killed, stopped and on full disks.
foreach(name web_flight_gl killed_flight_gl)
  gnomon_test(faults/${name}_test gnomon_fault_server PkgConfig::OPENIMAGEIO)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    GNOMON_PROGRAM="$<TARGET_FILE:gnomon>")
  add_dependencies(${name}_test gnomon)
endforeach()
