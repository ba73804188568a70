gnomon_test(window/orbit_test gnomon::command)

# The window itself, with a real pointer and real keys, where there is an X server to start.
add_test(NAME Window.OpensTurnsZoomsAndQuitsByHand
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/window_test.sh $<TARGET_FILE:gnomon>)
set_tests_properties(Window.OpensTurnsZoomsAndQuitsByHand PROPERTIES TIMEOUT 240 SKIP_RETURN_CODE 77)
