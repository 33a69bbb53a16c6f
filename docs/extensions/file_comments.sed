# A header's comment on its namespace, or the one it ends with, is about the header: a filter for Doxygen.
s,\n\(\(///[^\n]*\n\)\+\)namespace ,\n/// @file\n\1\nnamespace ,
t
s,\n\(\(///[^\n]*\n\)\+\)$,\n/// @file\n\1,
t
s,^,/// @file\n\n,
