# Compares OURS.csv with TRUTH.csv row by row, by the columns after `skip`: r,g,b and their standard errors in both.
# Prints the mean of (A - B)^2 / (EA^2 + EB^2), the difference of all points together in standard errors and in
# percent, and the relative rms difference without noise. Exit 1 when chi2 is 2 or more, or all together differ by four
# standard errors and 0.5 %. Usage: awk -F, -v skip=6 -f points.awk OURS.csv TRUTH.csv
/^[#x]/ { next }
FNR == NR { ours[++count] = $0; next }
{
    split(ours[++row], a, ",")
    for (k = 1; k <= skip && k <= 3; k++)
        if ((a[k] - $k) ^ 2 > 1e-12) { print "row " row ": another point"; bad = 1 }
    for (c = skip + 1; c <= skip + 3; c++) {
        noise = a[c + 3] ^ 2 + $(c + 3) ^ 2
        if (noise > 0) { chi2 += (a[c] - $c) ^ 2 / noise; values++ }
        else if (a[c] != $c) { print "row " row ": " a[c] " is not " $c " though both are sure"; bad = 1 }
        difference += a[c] - $c; sum += $c; sum2 += $c ^ 2; variance += noise
        square += (a[c] - $c) ^ 2
    }
    # one path carries the three channels: their noise adds up
    together += (a[skip + 4] + a[skip + 5] + a[skip + 6]) ^ 2 + ($(skip + 4) + $(skip + 5) + $(skip + 6)) ^ 2
}
END {
    if (!values || row != count) { print count + 0 " rows against " row + 0; exit 1 }
    chi2 /= values
    sigmas = difference / sqrt(together); percent = 100 * difference / sum
    left = square > variance ? sqrt((square - variance) / sum2) : 0
    printf "chi2 %.2f, together %.2f sigma %.3f %%, rms without noise %.3f %%\n", chi2, sigmas, percent, 100 * left
    if (chi2 >= 2 || (sigmas ^ 2 >= 16 && percent ^ 2 >= 0.25) || bad) exit 1
}
