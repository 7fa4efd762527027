# data: sh_orders.csv
set title 'Projection at records, upright pixels: error by order'
set xlabel 'order'
set ylabel 'RMS error / mean'
set logscale y
set yrange [0.1:200]
plot for [i = 2:7] data.'/sh_orders.csv' using 1:(100 * column(i)) skip 1 with linespoints \
    lc rgb hue[i - 1] pt 7 ps 0.6 title 'alpha '.word('1 0.7 0.5 0.3 0.2 0.1', i - 1), \
    1.5 dt 2 lc rgb '#888888' title '1.5%', 2.5 dt 3 lc rgb '#888888' title '2.5%', \
    5 dt 4 lc rgb '#888888' title '5%'
