// Line 3 does not compile: the tests look for its file and number in the error.
float fine() { return 1.0; }
float wrong() { return nothing_of_this_name; }
