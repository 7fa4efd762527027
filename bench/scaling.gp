# Time against what it grows with, both logarithmic; after docs/accuracy/style.gp. curves: a CSV file
# whose head names each curve and its fit; quantity: its first column; out: the SVG file.
set terminal svg size 340,350 font 'sans-serif,12' background '#ffffff'
set logscale xy
set format x '%.0s%c'
set format y '%g s'
do for [decade = -2:6] {
    set xtics add (3 * 10.0**decade)
    set ytics add (2 * 10.0**decade, 5 * 10.0**decade)
}
set xlabel quantity
set autoscale noextend
set offsets graph 0.08, graph 0.08, graph 0.08, graph 0.08
set bmargin 6.5
set key at screen 0.02, screen 0.1 left Left reverse vertical maxrows 2 samplen 1.5
# Columns: 2 and 4 are times, 3 and 5 their fits.
plot for [i = 0:1] curves using 1:(column(2 + 2 * i)) with points pt 7 ps 0.6 lc rgb hue[2 + 4 * i] title columnheader(2 + 2 * i), \
    for [i = 0:1] '' using 1:(column(3 + 2 * i)) with lines lw 1.5 lc rgb hue[2 + 4 * i] title columnheader(3 + 2 * i)
