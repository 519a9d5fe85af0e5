"""What the tests of the node share. This file also puts its folder, with the helpers in it, on the path of imports."""
