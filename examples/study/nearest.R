# Nearest other person by group of photos, of all photos and of those whose focal length was not assumed.
# Usage: Rscript nearest.R results
folder <- commandArgs(trailingOnly = TRUE)[1]
people <- read.csv(file.path(folder, "people.csv"))
photos <- read.csv(file.path(folder, "photos.csv"))
people <- merge(people, photos[, c("photo", "focal_assumed")])
compare <- function(people, title) {
  cat(title, "\n")
  nearest <- aggregate(nearest_m ~ photo, people, median)
  nearest$group <- dirname(nearest$photo)
  print(aggregate(nearest_m ~ group, nearest, function(x) round(c(n = length(x), median = median(x)), 2)))
  if (length(unique(nearest$group)) == 2) print(wilcox.test(nearest_m ~ group, nearest, exact = FALSE))
}
compare(people, "all photos")
# read.csv takes true and false for texts: "true" == TRUE is FALSE in R
known <- people[people$focal_assumed == "false", ]
if (nrow(known) > 0) compare(known, "photos whose focal length was not assumed")
